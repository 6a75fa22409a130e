"""Hours of a field day: memory, pace, and the shape of a real day."""

import importlib.util
import resource
import time
from dataclasses import replace
from pathlib import Path

from twin.logs.drive_statistics import drive_statistics, ratios
from twin.pipeline.named import load
from twin.simulation.build import build
from twin.simulation.simulate import simulate

ROOT = Path(__file__).parents[2]
HOURS = 8.0


def test_eight_hours_keep_their_memory_and_their_pace():
    """Processor time, so that others on the machine do not count."""
    day = load("scenario", "field-day-ploughing")
    machine = build(replace(day, course=replace(day.course, passes=200)))
    begin, early_kb, simulated_s = time.process_time(), 0, 0.0
    for chunk in simulate(machine):
        simulated_s = chunk.epoch_ns[-1] * 1e-9
        if simulated_s > 600.0 and not early_kb:
            early_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        if simulated_s > HOURS * 3600.0:
            break
    assert simulated_s > HOURS * 3600.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - early_kb < 50_000
    assert simulated_s / (time.process_time() - begin) > 40.0


def test_the_t7165s_day_changes_as_its_log_does():
    """Within a factor 1.5 while the engine runs; over the whole day where medians mean something.

    Half of the log stands, so that the medians of changes over the whole of it lie at the edge of
    standing: in the log that of the wheel speed is 0.
    """
    path = ROOT / "docs" / "field_day_picture.py"
    spec = importlib.util.spec_from_file_location("field_day_picture", path)
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    day = page.driven()
    for kept, engine_on in ((page.LOG, False), (page.LOG_ON, True)):
        found = ratios(drive_statistics(*day, engine_on=engine_on), kept)
        for name, ratio in found.items():
            if engine_on or "mad" not in name or "slip" in name:
                assert 1.0 / 1.5 < ratio < 1.5, name
