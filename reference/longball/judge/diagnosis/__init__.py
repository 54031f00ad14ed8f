"""The diagnosis of a candidate by edits of the model.

A mistake is a small edit of the reference: another symbol of the same unit, a sign, a factor, a
term that is left out, a state that is frozen at the launch. The diagnosis generates such edits
(`operators`) of the chain of a scene (`chain`), and looks for the cheapest one with which the
reference makes every number that the candidate made (`search`, `evidence`). What no edit makes is
located, not named. A candidate that moves in steps may be explained by its scheme (`schemes`), one
that writes few digits by those (`digits`), one that answers in other units or axes by these
(`outputs`), and its outcomes by edits of the conditions for them (`outcomes`).
"""
