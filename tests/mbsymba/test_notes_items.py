"""Where each item of the course notes is tested: none is without a test, and no test is named in vain."""

from __future__ import annotations

import inspect
from importlib import import_module

import pytest

# Item: module, and the tests in it.
ITEMS = {
    "N-01": "frames_and_points: describe_and_show, every_word_describes_itself",
    "N-02": "frames_and_points: global_frames_are_printed_as_in_the_notes, a_frame_and_its_inverse",
    "N-03": "frames_and_points: global_frames_are_printed_as_in_the_notes",
    "N-04": "frames_and_points: recursive_frames",
    "N-05": "frames_and_points: natural_frames",
    "N-06": "frames_and_points: unit_vectors_and_the_fourth_number",
    "N-07": "frames_and_points: unit_vectors_and_the_fourth_number",
    "N-08": "frames_and_points: a_point_by_hand_and_by_the_library",
    "N-09": "frames_and_points: a_point_by_hand_and_by_the_library",
    "N-10": "frames_and_points: joined_points_and_products; notes_printed: joined_points",
    "N-11": "frames_and_points: joined_points_and_products; notes_printed: joined_points",
    "N-20": "frames_and_points: constraints_of_joints; notes_printed: constraints_as_lists_and_all_of_them",
    "N-21": "frames_and_points: constraints_of_joints; notes_printed: constraints_as_lists_and_all_of_them",
    "N-22": "frames_and_points: constraints_of_joints; notes_printed: constraints_as_lists_and_all_of_them",
    "N-23": "frames_and_points: the_line_of_a_cam",
    "N-24": "notes_printed: constraints_as_lists_and_all_of_them",
    "N-25": "notes_kinematics: all_assemblies_and_the_one_that_is_meant",
    "N-26": "notes_kinematics: all_assemblies_and_the_one_that_is_meant",
    "N-27": "notes_kinematics: a_table_by_continuation",
    "N-30": "notes_kinematics: initial_positions_from_guesses_and_in_ranges",
    "N-31": "notes_kinematics: tau_is_what_solving_the_rates_gives",
    "N-32": "notes_kinematics: singular_configurations_are_those_with_the_constraints",
    "N-40": "pendulum: energies; notes_traps: the_fourth_argument_is_iyy",
    "N-41": "notes_printed: a_spring_and_a_damper",
    "N-42": "notes_printed: a_spring_and_a_damper",
    "N-43": "slider_crank: newton_and_euler_with_reactions_as_unknowns; reactions_and_index: "
            "the_index_is_reduced_in_three_steps",
    "N-44": "slider_crank: newton_and_euler_with_reactions_as_unknowns; four_ways: "
            "same_motion_same_reactions_and_newtons_law",
    "N-45": "slider_crank: newton_and_euler_with_reactions_as_unknowns; notes_printed: "
            "equations_of_index_three",
    "N-46": "slider_crank: lagrange_equations_lead_to_the_equation_set; pendulum: equation_of_motion",
    "N-47": "reactions_and_index: reactions_from_multipliers_by_virtual_displacements",
    "N-48": "reactions_and_index: the_index_is_reduced_in_three_steps",
    "N-49": "notes_dynamics: initial_conditions_the_special_way",
    "N-50": "notes_printed: analytic_solution_of_the_linear_equation; pendulum: motions",
    "N-51": "notes_dynamics: baumgarte_by_hand_and_by_name",
    "N-52": "notes_dynamics: baumgarte_by_hand_and_by_name",
    "N-53": "notes_dynamics: virtual_work_holds",
    "N-54": "notes_dynamics: equilibrium_in_two_ways",
    "N-55": "notes_dynamics: friction_of_the_notes",
    "N-56": "notes_dynamics: inverse_dynamics_from_the_equations_of_motion_alone",
    "N-57": "pendulum: a_stationary_motion_is_a_point_too; notes_printed: small_deviations_as_variables",
    "N-58": "pendulum: equation_of_motion, first_order",
    "N-59": "pendulum: first_order",
    "N-60": "pendulum: linear_equations",
    "N-61": "pendulum: linear_equations",
    "N-62": "pendulum: motions",
    "N-63": "pendulum: state_space_and_eigenvalues",
    "N-90": "notes_traps: linear_is_value_and_slope",
    "N-91": "notes_traps: the_fourth_argument_is_iyy",
    "N-92": "notes_traps: signs_of_the_state_space; pendulum: state_space_and_eigenvalues",
    "N-93": "notes_dynamics: friction_of_the_notes",
    "N-94": "notes_traps: multipliers_of_a_rod; notes_dynamics: baumgarte_by_hand_and_by_name",
    "N-95": "notes_traps: imaginary_eigenvalues_are_marginal",
    "N-96": "reactions_and_index: reactions_from_multipliers_by_virtual_displacements; slider_crank: "
            "newton_and_euler_with_reactions_as_unknowns",
    "N-97": "notes_kinematics: the_bracket_of_the_cam_is_refused, a_table_by_continuation",
    "N-98": "notes_traps: a_revolute_reaction_without_its_other_body",
}  # fmt: skip
GROUPS = ((1, 11), (20, 27), (30, 32), (40, 63), (90, 98))


def test_no_item_is_missing() -> None:
    assert list(ITEMS) == [f"N-{k:02d}" for first, last in GROUPS for k in range(first, last + 1)]


@pytest.mark.parametrize("item", ITEMS)
def test_its_tests_exist(item: str) -> None:
    for part in ITEMS[item].split(";"):
        module, names = part.strip().split(": ")
        found = import_module(f"tests.mbsymba.test_{module}")
        for name in names.split(", "):
            test = vars(found).get(f"test_{name.strip()}")
            assert inspect.isfunction(test), (item, name)
