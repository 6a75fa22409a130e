"""The suite that every shipped estimator passes, for estimators of your own.

    from twin.testing import check_estimator

    check_estimator(Mine())

Under pytest each check is a test of its own:

    @pytest.mark.parametrize("check", twin.testing.CHECKS)
    def test_mine(check):
        check(Mine())
"""

from twin.testing.drives import Drive, setup, streams
from twin.testing.suite import CHECKS, check_estimator

__all__ = ["CHECKS", "Drive", "check_estimator", "setup", "streams"]
