"""A small study in a world that takes no time."""

from __future__ import annotations

from pathlib import Path

from plausible_world import PlausibleWorld

from fake_world import make_course
from hotlap.configuration import Configuration
from hotlap.course import Course
from hotlap.goal import parse_goal
from hotlap.objective import Objective
from hotlap.report.page.standing import Standing, read_standing
from hotlap.study import Study, carry_out
from hotlap.tuning import TuningSettings


class AnyVehicle(PlausibleWorld):
    """Takes another vehicle, and flies as ever."""

    takes_truth = True

    def fly(self, course, parameters, seeds, *, truth=None, log=()):  # noqa: ARG002
        return super().fly(course, parameters, seeds, log=log)


def configure(course: Course | None = None, goal: str = "completion=1", **settings) -> Configuration:
    course = course or make_course()
    asked = TuningSettings(**{"seed": 3, "budget": 20, "validation": 20, "goal": parse_goal(goal), **settings})
    return Configuration(
        course, "plausible", asked.goal.metric, "metropolis_hastings:tied", asked, course.space.first_guess(len(course.segments))
    )


def carry(folder: Path, configuration: Configuration, world=None, command: str = "") -> Standing:
    """Run a study to its end, and read it."""
    with Study.open(folder, configuration, command) as study:
        carry_out(study, Objective(configuration.course, world or PlausibleWorld(), configuration.metric))
        return read_standing(study)


def begin(folder: Path, configuration: Configuration) -> Standing:
    """A study without flights."""
    with Study.open(folder, configuration) as study:
        return read_standing(study)
