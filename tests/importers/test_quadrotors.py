"""Quadrotors of other programs: levers or diagonals, thrust from speeds, drags; the numbers were checked by hand."""

from __future__ import annotations

from math import pi, sqrt

import pytest

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.importers import read
from hotlap.race.rotors import RotorLayout
from importers.changed import SAMPLES, changed


def test_a_drone_of_togt_has_the_diagonal_for_an_arm_where_it_has_an_angle(tmp_path):
    drone = read(SAMPLES / "togt_drone.yaml").description
    assert (drone.mass, drone.arm, drone.torque_ratio, drone.gravity) == (0.8, 0.12, 0.02, 9.8066)
    assert (drone.inertia, drone.rotor_thrust, drone.rate_limit) == ((1e-3, 1e-3, 1.7e-3), (0.1, 6.5), (12, 12, 3))
    lever = changed("togt_drone.yaml", tmp_path, ("beta:        45.0\n", ""))
    assert read(lever).description.arm == pytest.approx(0.12 * sqrt(2))


def test_a_drone_of_togt_may_say_its_levers_in_a_matrix(tmp_path):
    rows = "T_bm: [[1, 1, 1, 1], [0.15, -0.15, -0.15, 0.15], [-0.15, -0.15, 0.15, 0.15], [0.05, -0.05, 0.05, -0.05]]"
    drone = read(changed("togt_drone.yaml", tmp_path, ("armLength:   0.12\n", f"{rows}\n"))).description
    assert (drone.arm, drone.layout, drone.torque_ratio) == (pytest.approx(0.15 * sqrt(2)), RotorLayout.X, 0.05)


def test_which_way_the_first_rotor_of_togt_turns_does_not_matter(tmp_path):
    rows = "T_bm: [[1, 1, 1, 1], [0.15, -0.15, -0.15, 0.15], [-0.15, -0.15, 0.15, 0.15], [-0.05, 0.05, -0.05, 0.05]]"
    assert read(changed("togt_drone.yaml", tmp_path, ("armLength:   0.12\n", f"{rows}\n"))).description.torque_ratio == 0.05


def test_an_angle_of_togt_other_than_45_degrees_makes_two_levers(tmp_path):
    imported = read(changed("togt_drone.yaml", tmp_path, ("beta:        45.0", "beta:        30.0")))
    assert imported.description.arm == pytest.approx(0.12)
    assert any("levers of 0.06 m for roll and 0.1039 m for pitch" in remark for remark in imported.lost)


def test_a_matrix_of_a_plus_is_a_plus(tmp_path):
    rows = "T_bm: [[1, 1, 1, 1], [0.0, -0.15, 0.0, 0.15], [-0.15, 0.0, 0.15, 0.0], [0.05, -0.05, 0.05, -0.05]]"
    drone = read(changed("togt_drone.yaml", tmp_path, ("armLength:   0.12\n", f"{rows}\n"))).description
    assert (drone.arm, drone.layout) == (pytest.approx(0.15), RotorLayout.PLUS)


def test_the_arm_of_rpg_time_optimal_is_a_lever_and_its_thrust_may_be_a_ratio(tmp_path):
    imported = read(SAMPLES / "rpg_quadrotor.yaml")
    drone = imported.description
    assert drone.arm == pytest.approx(0.1 * sqrt(2))
    assert drone.rotor_thrust == (0.2, pytest.approx(3.0 * 0.8 * 9.81 / 4))
    assert drone.rate_limit == (15, 15, 0.3)
    assert any("planning.ramp = { distance = 30, thrust_to_weight = 1.5, rate = 4.5 }" in remark for remark in imported.lost)
    newtons = changed("rpg_quadrotor.yaml", tmp_path, ("TWR_max:        3.0", "thrust_max: 6.0\ndrag_coeff: 0.3"))
    assert read(newtons).description.rotor_thrust == (0.2, 6.0)
    assert read(newtons).description.drag == (0.3, 0.3, 0.3)


def test_a_quadrotor_of_agilicious_sits_where_its_rotors_are(tmp_path):
    imported = read(SAMPLES / "agilicious.yaml")
    drone = imported.description
    assert (drone.arm, drone.layout) == (pytest.approx(0.1), RotorLayout.X)  # 0.08 and 0.06 m
    assert (drone.rotor_thrust, drone.torque_ratio, drone.motor_time) == ((0, 5.5), 0.016, (0.03, 0.03))
    assert drone.drag == pytest.approx((0.5, 0.5, 0.25))  # over 0.8 kg
    assert [remark.partition(":")[0] for remark in imported.lost[:3]] == ["rotor positions", "aero_coeff_3", "aero_coeff_h"]
    by_speed = changed("agilicious.yaml", tmp_path, ("thrust_max:       5.5\n", ""))
    assert read(by_speed).description.rotor_thrust[1] == pytest.approx(1.5e-6 * 2000**2)
    idling = changed("agilicious.yaml", tmp_path, ("thrust_min:       0.0\n", ""))
    assert read(idling).description.rotor_thrust == (pytest.approx(1.5e-6 * 150**2), 5.5)


def test_a_quadrotor_of_fast_fly_has_the_diagonal_for_an_arm():
    drone = read(SAMPLES / "fast_fly_quadrotor.yaml").description
    assert (drone.arm, drone.drag, drone.rate_limit) == (0.3, (0.4, 0.3, 0.2), (6, 6, 2))


def test_a_vehicle_of_the_mrs_simulator_has_the_inertia_of_a_cylinder():
    drone = read(SAMPLES / "mrs.yaml").description
    assert drone.name == "kite"
    assert drone.inertia == pytest.approx((1.2 * (3 * 0.04 + 0.01) / 12, 0.013, 1.2 * 0.04 / 2))
    assert drone.rotor_thrust == pytest.approx((0.1, 8.1))  # 1e-7 N a squared revolution a minute
    assert drone.body_drag == pytest.approx([0.3 * pi * 0.04] * 3)
    assert (drone.arm, drone.layout, drone.radius) == (pytest.approx(0.2), RotorLayout.X, pytest.approx(0.3))


def test_one_of_several_vehicles_is_chosen_by_its_name():
    drone = read(SAMPLES / "drone_models.toml", "small").description
    assert (drone.name, drone.arm) == ("small", pytest.approx(0.03 * sqrt(2)))
    assert (drone.motor_time, drone.drag) == ((0.0625, 0.0625), pytest.approx((0.5, 0.5, 0.75)))
    assert drone.outer_radius == pytest.approx(0.03 * sqrt(2) + 0.025)
    with pytest.raises(InputError, match=r"describes 2 vehicles; choose one with name=\.\.\.: small, smaller"):
        read(SAMPLES / "drone_models.toml")
    with pytest.raises(UnknownNameError, match="no vehicle named 'smal'"):
        read(SAMPLES / "drone_models.toml", "smal")


def test_a_model_of_gazebo_weighs_all_its_links_about_their_common_centre():
    imported = read(SAMPLES / "px4.sdf")
    drone = imported.description
    assert drone.name == "hawk"
    assert drone.mass == pytest.approx(1.4 + 4 * 0.01 + 0.06)
    x, z = 0.06 * 0.06 / 1.5, 4 * 0.01 * 0.02 / 1.5  # the centre of mass: a weight of 0.06 kg lies 0.06 m ahead
    about_x = 0.02 + 4 * (1e-6 + 0.01 * (0.2**2 + 0.02**2)) + 1e-6 - 1.5 * z**2
    about_z = 0.04 + 4 * (2e-6 + 0.01 * 0.25**2) + 1e-6 + 0.06 * 0.06**2 - 1.5 * x**2
    assert (drone.inertia[0], drone.inertia[2]) == (pytest.approx(about_x), pytest.approx(about_z))
    assert drone.arm == pytest.approx(0.25, rel=1e-3)
    assert any("0.2 m for roll and 0.15 m for pitch" in remark for remark in imported.lost)


def test_a_rotor_of_gazebo_lifts_by_the_square_of_its_speed_and_drags_by_the_root_of_its_thrust():
    drone = read(SAMPLES / "px4.sdf").description
    assert drone.rotor_thrust == (0, pytest.approx(6.4e-6 * 1000**2))
    assert (drone.torque_ratio, drone.motor_time) == (0.05, (0.0125, 0.025))
    thrust, speed = 3.6e-6 * 6.4, sqrt(3.6)  # of a rotor at sqrt(3.6) rad/s
    assert drone.rotor_drag * sqrt(thrust * 1e6) == pytest.approx(1e-4 * speed * 1e3)


def test_a_model_that_includes_its_links_is_read_from_the_folder_beside(tmp_path):
    drone = read(SAMPLES / "model" / "model.sdf").description
    assert (drone.name, drone.mass, drone.arm) == ("owl", pytest.approx(1.44), pytest.approx(0.2 * sqrt(2)))
    with pytest.raises(InputError, match="none of its links has a mass"):
        read(changed("model/model.sdf", tmp_path))


def test_a_model_may_include_one_that_includes_its_links(tmp_path):
    for name in ("model", "model_base"):
        (tmp_path / name).mkdir()
        changed(f"{name}/model.sdf", tmp_path / name)
    top = tmp_path / "top" / "model.sdf"
    top.parent.mkdir()
    words = "<sdf><model name='top'><include merge='true'><uri>model</uri></include>{}</model></sdf>"
    top.write_text(words.format(""), encoding="utf-8")
    assert read(top).description.mass == pytest.approx(1.44)
    top.write_text(words.format("<include><uri>model://top</uri></include>"), encoding="utf-8")
    with pytest.raises(InputError, match="includes itself"):
        read(top)


def test_models_that_include_more_and_more_are_refused(tmp_path):
    for k in range(5):
        (tmp_path / f"m{k}").mkdir()
        inner = f"<include><uri>model://m{k + 1}</uri></include>" * 20
        (tmp_path / f"m{k}" / "model.sdf").write_text(f"<sdf><model name='m{k}'>{inner}</model></sdf>", encoding="utf-8")
    with pytest.raises(InputError, match="includes more than 100 models"):
        read(tmp_path / "m0" / "model.sdf")


def test_rotors_that_lean_and_wings_are_named(tmp_path):
    wing = "<plugin name='w' filename='libLiftDragPlugin.so'/><model name='gps'>"
    leaning = read(changed("px4.sdf", tmp_path, ("0.15 0.2 0.02 0 0 0", "0.15 0.2 0.02 0.2 0 0"), ("<model name='gps'>", wing)))
    assert "rotor axes: tilted by up to 11 deg; ours push along the body's z axis" in leaning.lost
    assert "plugins of lift and drag: wings" in leaning.lost


def test_a_pose_that_stands_on_itself_is_refused(tmp_path):
    round_about = changed("px4.sdf", tmp_path, ("relative_to='base_link'", "relative_to='rotor_0'"))
    with pytest.raises(InputError, match="stands on itself"):
        read(round_about)


@pytest.mark.parametrize("angle", ["0 0 1.5707963267948966</pose>", "0 0 90</pose>"])
def test_angles_of_a_pose_turn_what_stands_on_it(tmp_path, angle):
    ahead, left = "<pose>0.06 0 0 0 0 0</pose>", "<pose>0 0.06 0 0 0 0</pose>"
    straight = read(changed("px4.sdf", tmp_path, (ahead, left))).description
    turned = f"<pose>0 0 0 {angle}"
    if "90" in angle:
        turned = turned.replace("<pose>", "<pose degrees='true'>")
    about = read(changed("px4.sdf", tmp_path, (ahead, turned), ("<link name='link'>", f"<link name='link'>{ahead}"))).description
    assert about.inertia == pytest.approx(straight.inertia)
    assert about.inertia != pytest.approx(read(SAMPLES / "px4.sdf").description.inertia)


def test_the_axes_of_an_inertia_turn_with_its_pose(tmp_path):
    base = "<mass>1.4</mass>\n        <inertia><ixx>0.02</ixx>"
    turned = "<pose>0 0 0 0 0 1.5707963267948966</pose><mass>1.4</mass><inertia><ixx>0.03</ixx>"
    x, y, _ = read(SAMPLES / "px4.sdf").description.inertia
    assert read(changed("px4.sdf", tmp_path, (base, turned))).description.inertia[:2] == pytest.approx((x, y + 0.01))


def test_rotors_of_gazebo_are_seen_from_the_centre_of_mass(tmp_path):
    heavy = read(changed("px4.sdf", tmp_path, ("<pose>0.06 0 0 0 0 0</pose>", "<pose>2.5 0 0 0 0 0</pose>"))).description
    ahead = 2.5 * 0.06 / 1.5
    assert heavy.arm == pytest.approx((sqrt((0.15 - ahead) ** 2 + 0.2**2) + sqrt((0.15 + ahead) ** 2 + 0.2**2)) / 2)


def test_a_drone_of_pybullet_has_its_thrust_from_its_weight():
    imported = read(SAMPLES / "pybullet.urdf")
    drone = imported.description
    assert (drone.name, drone.arm, drone.layout) == ("wasp", 0.05, RotorLayout.X)
    assert drone.rotor_thrust == (0, pytest.approx(2.5 * 0.04 * 9.81 / 4))
    assert drone.torque_ratio == pytest.approx(1.0e-11 / 4.0e-10)
    assert drone.motor_time == (0, 0)
    turns = 20_000.0  # revolutions a minute: 0.16 N, and 1e-6 N s/m for each rad/s
    assert drone.rotor_drag * sqrt(4.0e-10 * turns**2) == pytest.approx(1.0e-6 * turns * 2 * pi / 60)


def test_an_arm_of_pybullet_that_is_not_where_its_propellers_are_is_named(tmp_path):
    imported = read(changed("pybullet.urdf", tmp_path, ('arm="0.05"', 'arm="0.06"')))
    assert imported.description.arm == pytest.approx(0.05, rel=0.01)
    assert any(remark.startswith("properties.arm = 0.06 m: the propellers sit 0.0") for remark in imported.lost)


def test_propellers_that_would_overlap_do_not_set_the_size(tmp_path):
    wide = read(changed("pybullet.urdf", tmp_path, ('prop_radius="0.02"', 'prop_radius="0.04"')))
    assert wide.description.radius is None
    assert any("would overlap" in remark for remark in wide.lost)


@pytest.mark.parametrize(
    ("sample", "change", "said"),
    [
        ("mrs.yaml", ("n_motors: 4", "n_motors: 6"), "mrs.yaml: kite: has 6 rotors; hotlap flies vehicles with 4"),
        ("px4.sdf", ("<linkName>rotor_3", "<motorNumber>3</motorNumber><linkName>rotor_9"), "there is no link rotor_9"),
        ("pybullet.urdf", ("prop3_link", "arm3_link"), "has 3 rotors; hotlap flies vehicles with 4"),
        ("pybullet.urdf", ("<properties", "<other"), "has no <properties> with kf, km and thrust2weight"),
        ("px4.sdf", ("motorConstant", "liftConstant"), "no model has plugins of motors"),
    ],
)
def test_what_hotlap_cannot_fly_is_refused_with_the_reason(tmp_path, sample, change, said):
    with pytest.raises(InputError) as error:
        read(changed(sample, tmp_path, change))
    assert said in str(error.value)


def test_what_matters_and_is_not_said_is_named():
    assert "motor_time, rate_gain, delay, drag stay at the defaults" in read(SAMPLES / "rpg_quadrotor.yaml").lost[-1]
