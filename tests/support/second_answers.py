"""Where each number has a second, independent answer: tests by the kind of it, for the page of the site."""

SECOND_ANSWERS = {
    "Fifty digits": (
        "Another way to the same number, written apart from camopt in mpmath: slow, obvious, and stable when its "
        "precision is doubled.",
        (
            "solve/verdicts/test_evaluation.py::test_worked_cams_of_the_sources",
            "solve/verdicts/test_evaluation.py::test_each_mechanism_and_law_against_fifty_digits",
            "whole/test_naive.py::test_closed_forms_at_random_points",
            "model/motion/test_motion.py::test_laws_against_fifty_digits",
            "model/motion/test_motion.py::test_tables_are_as_good_as_they_say_and_lie_in_their_ranges",
            "model/motion/test_scca.py::test_any_shares_against_fifty_digits_and_exactly",
            "model/motion/test_polynomials.py::test_any_conditions_against_fifty_digits_and_exactly",
            "model/motion/test_turned.py::test_a_skewed_law_against_fifty_digits_and_exactly",
            "model/effects/test_loads.py::test_all_loads_against_fifty_digits",
            "model/effects/test_torque.py::test_all_quantities_against_fifty_digits",
            "model/effects/test_vibration.py::test_the_response_against_fifty_digits",
            "model/effects/test_vibration.py::test_spectra_against_fifty_digits",
            "model/effects/test_point_contact.py::test_pressure_and_ellipse_against_fifty_digits",
            "model/effects/test_section.py::test_sections_in_fifty_digits",
            "solve/measured/test_profile.py::test_an_eccentric_in_50_digits",
        ),
    ),
    "Formulas in print": (
        "Beside the numbers above: whole curves that books give by a formula.",
        (
            "model/motion/test_scca.py::test_displacements_are_those_in_print",
            "model/motion/test_polynomials.py::test_the_eighth_power_polynomial_is_that_in_print",
            "model/motion/test_polynomials.py::test_rest_at_both_ends_gives_the_polynomials_of_the_books",
            "model/motion/test_arcs.py::test_a_tangent_cam_is_that_of_the_book",
            "model/motion/test_arcs.py::test_a_three_arc_cam_under_a_flat_face_is_that_of_the_book",
            "solve/synthesis/test_synthesis.py::test_classical_optima_of_the_calculus_of_variations",
            "model/effects/test_loads.py::test_parallel_cylinders_by_the_formula_of_the_textbooks",
        ),
    ),
    "Another model": (
        "The same question asked of bodies, equilibrium or an integrator in place of a formula.",
        (
            "model/motion/test_arcs.py::test_the_motion_is_that_of_a_follower_lowered_on_the_cam",
            "model/effects/test_loads.py::test_guide_and_stem_are_in_equilibrium",
            "model/effects/test_friction.py::test_loads_of_random_scenes_are_those_of_the_follower_in_equilibrium",
            "model/effects/test_surface.py::test_against_the_velocities_of_the_bodies",
            "model/effects/test_vibration.py::test_against_an_integrator",
            "solve/smallest/test_optimise.py::test_the_radius_of_a_radial_roller_cam",
            "solve/smallest/test_optimise.py::test_a_dense_scan_of_sizes_finds_the_same_least_radius",
            "show/exporting/test_cad.py::test_a_groove_read_back_is_whole_and_touches_its_roller_at_every_depth",
            "show/exporting/test_machines.py::test_a_wheel_that_follows_the_table_touches_the_profile",
            "show/exporting/test_machines.py::test_a_program_cuts_the_profile",
        ),
    ),
    "Identities": (
        "What must be so whatever the numbers are.",
        (
            "model/effects/test_torque.py::test_the_energy_balance_closes",
            "model/effects/test_torque.py::test_inertia_is_linear_in_mass_and_square_in_speed",
            "model/effects/test_loads.py::test_a_mirrored_cam_has_the_same_loads",
            "model/effects/test_loads.py::test_lengths_scale",
            "whole/test_hard_cases.py::test_lengths_scaled_by_powers_of_two_scale_exactly",
            "model/motion/test_arcs.py::test_a_cw_cam_is_the_mirror_image",
            "model/effects/test_point_contact.py::test_the_two_radii_may_change_places",
            "model/effects/test_vibration.py::test_the_order_of_the_segments_does_not_matter",
            "solve/smallest/test_prices.py::test_a_price_is_the_derivative_of_the_smallest_size",
        ),
    ),
    "Limits of one model in another": (
        "Where a model goes over into a simpler one.",
        (
            "model/effects/test_loads.py::test_a_huge_roller_is_a_flat_face",
            "model/effects/test_point_contact.py::test_a_slender_contact_is_nearly_a_line",
            "model/effects/test_vibration.py::test_a_stiff_train_bends_with_the_acceleration",
            "model/effects/test_vibration.py::test_on_a_soft_train_the_mass_stays_at_the_mean",
        ),
    ),
    "Enclosures and proofs": (
        "What is said to be proved, against dense samples, polygons and exact arithmetic.",
        (
            "core/numerics/test_extremes.py::test_extremes_are_those_of_dense_sampling",
            "core/numerics/test_extremes.py::test_jets_hold_all_that_they_may_and_no_more",
            "solve/verdicts/test_proof.py::test_what_rounding_hides_is_undecided_and_no_more_than_that",
            "solve/verdicts/test_proof.py::test_limits_on_either_side_of_a_fifty_digit_extreme",
            "solve/verdicts/test_kinds_of_number.py::test_a_limit_is_decided_alike_on_either_side_of_its_bound",
            "solve/smallest/test_optimise.py::test_no_grid_finds_a_smaller_cam",
            "solve/synthesis/test_synthesis.py::test_no_motion_passes_the_bound",
            "solve/contour/test_contour.py::test_the_path_is_within_its_proved_deviation",
            "whole/test_hard_cases.py::test_no_point_of_a_curve_lies_outside_of_its_enclosure",
            "whole/test_hard_cases.py::test_the_undercut_verdict_flips_on_the_right_side",
            "model/effects/test_crossing.py::test_the_proof_agrees_with_a_polygon",
            "show/studies/test_accuracy.py::test_enclosures_keep_their_promise_for_every_mechanism",
        ),
    ),
    "Orders of convergence": (
        "Errors that fall with the power that theory says.",
        (
            "core/numerics/test_enclosure.py::test_the_excess_width_falls_with_the_square_of_the_box",
            "model/effects/test_section.py::test_a_section_is_that_of_a_polygon_of_many_points",
            "model/effects/test_section.py::test_a_rule_is_exact_for_polynomials",
        ),
    ),
}
"""By kind: what it is, and the tests by file and name."""
