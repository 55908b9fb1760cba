"""The battery of a quadrotor: what its keys mean, and what is refused."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hotlap.files.descriptions import load_quadrotor, load_race
from hotlap.race.battery import Battery

HUMMINGBIRD = load_quadrotor("hummingbird")


def test_an_hour_of_hover_costs_the_share_of_its_ampere_hours():
    battery = Battery(sag_per_ampere_hour=0.02, hover_current=12.0)
    drone = HUMMINGBIRD.model_copy(update={"battery": battery})
    weight = drone.mass * drone.gravity
    assert drone.charge_sag * weight**1.5 * 3600 == pytest.approx(0.02 * 12.0)


def test_a_quadrotor_without_a_battery_loses_nothing():
    assert HUMMINGBIRD.battery is None
    assert (HUMMINGBIRD.sag, HUMMINGBIRD.charge_sag) == (0.0, 0.0)


def test_a_battery_by_charge_needs_a_current():
    with pytest.raises(ValidationError, match="hover_current: is missing"):
        Battery(sag_per_ampere_hour=0.1)


def test_a_race_may_give_its_vehicle_a_battery(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('base = "circle-34"\n[vehicle.battery]\nsag = 0.15\n')
    race = load_race(path)
    assert race.vehicle.sag == 0.15
    assert race.control_model.battery is None
