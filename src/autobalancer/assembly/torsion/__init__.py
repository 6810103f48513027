"""What twists between motor and rotor: links for runs, and their matrices."""
