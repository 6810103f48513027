"""The rotor: what drives and shakes it, and how it moves under the forces of its balls."""
