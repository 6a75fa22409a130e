"""Many runs: scenarios x seeds x sweeps of their fields, every estimator on each.

    plan       which runs there are, which of a sweep are left out, the name of each one's part
    part       one run: simulate, estimate, score, write its part when it ends
    work       the runs that have no part yet, in processes or on a cluster, by joblib
    table      all parts of a plan as one table
    summary    means with intervals over the seeds
    figures    what the summary looks like

A study is a folder. What is done is what has its part there, so a killed one goes on with what is
missing, and nothing is kept in memory.
"""

from twin.studies.plan import Case, left_out, plan
from twin.studies.summary import Group, early_ends, groups, quantities, rows
from twin.studies.table import failed, read, write_table
from twin.studies.work import missing, work

__all__ = [
    "Case", "Group", "early_ends", "failed", "groups", "left_out", "missing", "plan",
    "quantities", "read", "rows",
    "work", "write_table",
]  # fmt: skip
