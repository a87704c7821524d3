"""The paper's claims: its virtual experiment, and every number and sentence of it printed against computed."""
