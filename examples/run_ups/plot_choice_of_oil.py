"""
Which oil for a centrifuge?
===========================

The unbalance changes with every load, the room is cool or warm, and the balls start anywhere. A specification names what is
asked; closed forms and border speeds rule out what cannot do, and runs with scatter decide among the rest.
"""

# %%
# The rotor is the discoidal rig of Spannan (2021) with two balls; the oils are those of his runs, and a thinner one.

import autobalancer as ab

found = ab.design(
    {
        "machine": ab.example("discoidal"),
        "operation": {"speed": "1200 rpm", "run_up": "60 s", "hold": "20 s"},
        "unbalance": {"from": "500 g*mm", "to": "594 g*mm"},
        "temperature": {"from": "22 degC", "to": "28 degC"},
        "limits": {"border_margin": 0.1, "peak_deflection": "1.5 mm", "stall_probability": 0.08, "share": 0.9},
        "candidates": {
            "count": [2],
            "fluids": ["silicone oil 2", "silicone oil 5", "silicone oil 20", "silicone oil 50"],
        },
        "search": {"members": 60},
    }
)
print(found)

# %%
# The thin oil never runs: its balls would stall at the critical speed. Of the others the middle one wins. In the thin one the
# balls swing for long, in the thick one they creep, and the rotor passes its critical speed with a greater deflection: the balls
# turn with it and add to the unbalance. In the experiments, too, the balls scattered least in the oil of 20 mm²/s.

picture = ab.plot.design(found)

# %%
# The chosen machine can be saved, run and reported.

print(ab.designed_machine(found))
