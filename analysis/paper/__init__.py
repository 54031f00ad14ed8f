"""The paper, reproduced: what it prints, what we get, and which reading of it comes nearest.

`printed` has what it prints, and `pitch_fits` its data analysis. `balls` strikes at-bats;
`distances` measures how far a reading is from Figs. 6 and 7. `switches`, `numbers`, `combinations`
and `variance` are the parts of the study `readings`; `argument` tests the reasoning behind the
form of P(e); `home_run_figures` has Table I and Figs. 6 and 7; `counterparts` sums up.
"""
