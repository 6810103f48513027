"""Pictures of laws and measurements: drag, equilibrium angles, receptances, fits, flow."""
