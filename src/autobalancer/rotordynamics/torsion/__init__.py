"""How a drive train twists freely, at which speeds it is in resonance, and how it responds."""
