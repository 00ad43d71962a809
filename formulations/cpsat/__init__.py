"""CP-SAT models. Their bounds are the solver's claims: CP-SAT gives no proof that could be checked."""
