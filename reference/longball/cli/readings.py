"""``longball readings``."""

from __future__ import annotations

import json

from longball.cli.messages import progress_bar, show
from longball.cli.options import Options
from longball.home_run import Estimate, estimates, paper_at_bats
from longball.model.jsonl import json_or_number
from longball.model.readings import LEDGER, Entry, Reading, SamplingReading, readings_of
from longball.model.scene import AtBatScene

Readings = tuple[Reading, SamplingReading]


def readings(o: Options) -> None:
    """Print the ledger of readings, and the effect of each one on P(e)."""
    lines = [(entry, option) for entry in LEDGER for option in entry.options]
    effects: dict[Readings | None, Estimate] = {}
    if o.samples:
        # The defaults of all switches are the same reading: solve it once.
        switched = dict.fromkeys(chosen for line in lines if (chosen := readings_with(*line)))
        with progress_bar("readings", len(switched)) as advance:
            for done, (reading, sampling) in enumerate(switched, 1):
                base = AtBatScene(id="base", reading=reading)
                (effects[reading, sampling],) = estimates(
                    base,
                    paper_at_bats(sampling),
                    [o.e],
                    o.samples,
                    o.seed,
                    sample_space=sampling.sample_space,
                    workers=o.workers,
                )
                advance(done)
    rows, table = [], []
    for entry, option in lines:
        row = effects.get(readings_with(entry, option))
        effect = {"e": row.e, "p": row.p, "low": row.low, "high": row.high} if row else {}
        numbers = [f"{row.p:.4f}", f"{row.low:.4f} to {row.high:.4f}"] if row else ["", ""]
        default = option == entry.options[0]
        rows.append({"switch": entry.switch, "option": option, "default": default} | effect)
        shown = f"{option} (default)" if default else option
        table.append((entry.switch, entry.belongs, shown, *numbers))
    if o.json:
        keys = "switch", "belongs", "place", "why"
        ledger = [{key: getattr(entry, key) for key in keys} for entry in LEDGER]
        print(json.dumps({"rows": rows, "ledger": ledger}, ensure_ascii=False))
        return
    head = (f"P({o.e:g})", "95 %") if o.samples else ("", "")
    show(("switch", "belongs to", "option", *head), table)
    for entry in LEDGER:
        print(f"{entry.switch} ({entry.place}): {entry.why}")


def readings_with(entry: Entry, option: str) -> Readings | None:
    """Return the default readings with one switch set; None if P(e) does not depend on it."""
    if not entry.is_switch or entry.belongs in ("scheme", "figure"):
        return None
    return readings_of({entry.switch: json_or_number(option)})
