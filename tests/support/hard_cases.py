"""The hard cases of the numbers, each with the tests that hold it, for the page of the site."""

HARD_CASES = {
    "The offset nears, equals or exceeds the prime radius": (
        "whole/test_hard_cases.py::test_offset_next_to_the_prime_radius",
        "whole/test_hard_cases.py::test_sizes_whose_sum_rounds_next_to_the_prime_radius",
        "whole/test_hard_cases.py::test_a_peak_next_to_the_end_of_a_return",
        "whole/test_hard_cases.py::test_offset_at_or_beyond_the_prime_radius_is_refused",
    ),
    "The pitch curve has an inflection (κ = 0) or a cusp (s = 0 and y' = e)": (
        "whole/test_hard_cases.py::test_the_pitch_curve_has_an_inflection_up_to_a_prime_radius",
        "whole/test_hard_cases.py::test_a_cusp_of_the_pitch_curve",
    ),
    "The roller is 10⁻ᵏ larger or smaller than the least radius of the pitch curve, k = 1 … 12": (
        "whole/test_hard_cases.py::test_the_undercut_verdict_flips_on_the_right_side",
        "solve/verdicts/test_evaluation.py::test_the_undercut_verdict_flips_at_the_critical_roller",
    ),
    "Uniform velocity has corners, under every contact": (
        "whole/test_hard_cases.py::test_uniform_velocity_has_corners_under_every_contact",
        "solve/verdicts/test_evaluation.py::test_uniform_velocity_a_knife_follows_the_corner_and_a_roller_is_undercut",
    ),
    "The acceleration jumps, and each side has its own value": (
        "whole/test_hard_cases.py::test_accelerations_at_jumps_are_one_sided",
        "model/motion/test_motion.py::test_jumps_are_known_as_such",
    ),
    "A rise takes 0.01° or nearly the whole turn, over 1e-9 or 1e6 mm; the base radius is 1e-6 or 1e9 mm": (
        "whole/test_hard_cases.py::test_extreme_angles_and_lifts",
        "whole/test_hard_cases.py::test_extreme_base_radii",
        "model/motion/test_motion.py::test_extreme_strokes_have_exact_peaks",
    ),
    "A law is asked 1e-300 of the stroke after its start, or next to its end": (
        "whole/test_hard_cases.py::test_laws_are_exact_at_the_very_ends",
        "whole/test_hard_cases.py::test_shipped_laws_are_as_exact_next_to_the_end",
    ),
    "The curvature has a peak between coarse samples": (
        "core/numerics/test_extremes.py::test_a_peak_narrower_than_a_panel_is_found",
        "core/numerics/test_extremes.py::test_narrow_peaks_of_many_cams_next_to_the_limit",
    ),
    "Feasible base radii are a narrow island": (
        "solve/smallest/test_windows.py::test_windows_are_found_or_proved_absent",
        "solve/smallest/test_windows.py::test_a_window_that_no_coarse_grid_sees_is_found",
    ),
    "The triangle of an oscillating follower is nearly flat; a flat face turns nearly as fast as the cam": (
        "whole/test_hard_cases.py::test_an_oscillating_follower_next_to_a_flat_triangle",
        "whole/test_hard_cases.py::test_a_flat_face_that_nearly_turns_as_fast_as_the_cam",
        "model/effects/test_loads.py::test_a_face_that_turns_as_fast_as_the_cam",
    ),
    "The profile crosses itself far from any sharp curvature": (
        "whole/test_hard_cases.py::test_global_self_crossing_with_harmless_curvature",
        "model/effects/test_crossing.py::test_the_verdict_flips_where_the_flanks_touch",
    ),
    "Angles add up to 360° only after rounding, a dwell has no length, a turn has one segment": (
        "whole/test_hard_cases.py::test_angles_that_close_only_after_rounding",
        "whole/test_hard_cases.py::test_dwells_of_no_length_are_nothing",
        "whole/test_hard_cases.py::test_a_turn_of_one_segment_is_refused",
    ),
    "A Pareto set has ties, duplicates and infinite objectives, with and without wide vectors": (
        "whole/test_hard_cases.py::test_pareto_ties_duplicates_and_infinities",
        "whole/test_hard_cases.py::test_ties_are_ties_with_and_without_wide_vectors",
        "solve/front/test_front_search.py::test_ties_and_infinities",
    ),
    "A flank nearly conforms to the roller": (
        "whole/test_hard_cases.py::test_a_flank_that_nearly_conforms_to_the_roller",
        "model/effects/test_forces.py::test_a_nearly_conforming_flank_has_hardly_any_stress",
    ),
    "All lengths are scaled by a power of two": (
        "whole/test_hard_cases.py::test_lengths_scaled_by_powers_of_two_scale_exactly",
        "whole/test_hard_cases.py::test_lengths_out_of_range_are_refused",
        "solve/verdicts/test_evaluation.py::test_lengths_scaled_by_a_power_of_two_scale_the_result_bit_for_bit",
    ),
    "The cam is mirrored": (
        "solve/verdicts/test_evaluation.py::test_a_mirrored_scene_gives_the_same_bits",
        "model/effects/test_crossing.py::test_mirrored_and_scaled_cams_have_the_same_verdict",
    ),
    "Compiled, uncompiled and 50-digit results are compared": (
        "whole/test_hard_cases.py::test_compiled_and_uncompiled_agree_bit_for_bit",
        "core/kernels/test_kernels.py::test_compiled_and_plain_extremes_are_the_same_bits",
        "solve/verdicts/test_evaluation.py::test_each_mechanism_and_law_against_fifty_digits",
    ),
    "Workers, block sizes and the order of designs vary": (
        "solve/front/test_sweep.py::test_rows_do_not_depend_on_workers_or_blocks",
        "core/numerics/test_extremes.py::test_an_answer_does_not_depend_on_its_place_in_a_block",
    ),
}
