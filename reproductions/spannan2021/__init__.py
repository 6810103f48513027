"""L. Spannan, On the dynamic modelling of automatic ball balancers applied to laboratory centrifuges, 2021."""
