"""The numbers of compiled equations by name: one record for a ball, a contact, a wave, ..., each with units and meanings."""
