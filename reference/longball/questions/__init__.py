"""The questions that people ask of a ball in flight, above engines and derivatives."""
