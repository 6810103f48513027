"""L. Spannan, On the dynamic modelling of automatic ball balancers applied to laboratory centrifuges.

Dissertation, Magdeburg 2021.
"""
