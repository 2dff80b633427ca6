"""A small part of the hidden-effect suite: does `actuator diagnose` name what is there, and nothing where nothing is?

The cases are drawn by `hidden/`, from a plant that shares no code with the product; those here are plain enough that no sound
method may miss them. `python fmpy-tests/hidden/run.py --help` runs as many as one likes, `docs/hidden-effects.md` holds the outcome.
"""

import csv
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from actuator_fmu import Actuator, unpacked
from hidden import product, scoring


def slow(*cases):
    """Those for `./test --all`: a seed each, or a kind and a seed."""
    return [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow) for case in cases]


# (kind, seed): strong effects on records of 25 s and less. The seeds are part of the case: another one is another effect.
SINGLES = (26, 61)  # asymmetric gain, chatter
MORE_SINGLES = slow(57, 35, 49)  # backlash, position limit, shifted parameters
# An acceleration limit at an eighth of what the motion asks for.
FAR_BELOW_DEMAND = slow(300102)
PAIRS = (5,)  # asymmetric gain and sensor bias
# Friction, bias and a drift of the gain, where a likelier second effect is refuted by the check record; a rate limit, asymmetric gain and play, where one
# that takes next to nothing is likelier.
TRIPLES = slow(300010, 300005)
# A stiffness and a steady load of opposite signs: together they take little, the load by itself much.
LOADED = (301066,)
# A sensor's lag that a pole of the base, unseen by the fit of the model, explains as well; and one whose part a slower base has taken.
LAGS = {301052: "parameter_shift", 301157: "sensor_lag"}
# A coarse sensor, whose steps the values show: its base takes half of the difference when it is fitted without them.
COARSE_SENSORS = (280097,)
CLEAN = (3,)  # with white noise
MORE_CLEAN = slow(2, 8, 10)  # the first with coloured noise
OUTSIDE = (6,)  # omega that swings
TURBULENT = (450031, 674003)  # a load that no record holds, six and nine times the noise
# Of another structure. Healthy: what any effect explains beside a linear model, a linear base explains as well; a dead zone of another width in each
# record would be a small part of the difference. With a delay: friction and a base that is as late take more; the model was fitted to late records.
HEALTHY_RIGS = (*slow(170008), 240010)
# A rig whose friction takes half of what a base of its own leaves, which takes four fifths of the difference.
RUBBING_RIGS = slow(675022)
# Play, and friction of a rig that stands off its command, which are all, or most, that no linear system explains; a base of its own takes most of the difference.
BESIDE_A_BASE_OF_ITS_OWN = slow((672003, "backlash"), (678064, "coulomb_friction"))
# Geared rigs with friction, with and without play beside it, whose given model is off, or was fitted to them: hysteresis takes most of the difference.
HELD_BY_GIVEN_MODEL = (("rig_effect", 672007), *slow(("rig_healthy", 675010)))
# Friction of which most of the difference on the check records stays.
SLIGHTLY_RUBBING_RIGS = slow(460075)
# Friction that explains parts of the records, and whose simulation is further from a whole one, level included, than the model without it.
STICKING_ON_PARTS = slow(651030)
# Friction that is most of the difference.
STICKING_RIGS = slow(330168)
LATE_RIGS = slow(160018, 160009)
# A delay that leaves a four-hundredth of the difference, and a base that is slow leaves less than that by a third.
NEARLY_ALL_LATE = slow(430041)
# A limit that gains on parts of the records as it is, and on whole ones refitted.
LIMITED_RIGS = slow(180003)
# A stop at which positions stand, on a rig whose model has too small a gain to come there.
STOPPED_RIGS = slow(600186)
# A limit beside which friction and a lag are suspected; one in a trapezoid, where it begins to act within a sample as a slip of the sensor does.
LIMITED_AND_MORE = slow(430032, 450114)
# A limit that a check record does not meet: there the model with it differs from the given one by rounding alone.
UNMET_IN_CHECK = slow(450001)
# A valve with overlap, and a position that all records hold off its command.
OVERLAPPED_RIGS = slow(240004)
# Long records, whose stretches do not show what leads on the whole ones.
LONG_RECORDS = slow(260014)
# Long records under a sensor that drifts, and a base that is off: by levels of their own stretches are noise.
LONG_AND_DRIFTING = (674013,)
# Long records of which the check record alone meets a limit of rate; another limit beside a base of its own leaves less of all records than the base,
# but far more of the check record than what acts there.
ONLY_IN_CHECK = {280003: "command_rate_limit", 310002: "rate_limit"}
CONTRADICTED = {310002: ["acceleration_limit"]}
# The same on a rig of another structure, where the base of the fitted records tells another limit.
ONLY_IN_CHECK_OF_RIG = {500206: "acceleration_limit"}
# A limit that takes nearly all of the difference on unseen records, and leaves one of them with more than the given model does.
LEAVING_MORE = {320023: "acceleration_limit"}
# Biases that drift, one of them so that a staircase correlates best with steps of other signs, and hums, one of which a mode that hardly dies away takes as
# well, on rigs of another structure.
OF_SENSOR = {540015: "sensor_bias", 540036: "chatter", 662006: "chatter", 662016: "chatter", 663003: "sensor_bias", 663009: "sensor_bias", 664010: "sensor_bias"}
# With sensors and loggers of their own: a stepper behind an encoder; a servo whose negative commands reach less far.
INDEPENDENT_HEALTHY = slow(11)
INDEPENDENT_EFFECTS = slow(300003)
# A servo valve that answers late: a base alone leaves far less of the check record than a limit does.
INDEPENDENT_LATE = slow(310027)
# A healthy harmonic drive, under an uneven clock, whose model of order 2 has a damping ratio of 16.
HEAVILY_DAMPED_DRIVE = slow(700340)
# Nothing missing, and a command that is held although it was declared linear: under a clock that jitters, and beside a model that is off, where it looks
# like a mode; and a linear one declared held.
DECLARED_WRONGLY = {220292: "taken as held", 500057: "taken as held", 220050: "taken as linear"}
# Nothing missing, and a model that is far off: overdamped, with records that open in motion; of 2000 samples/s with a command that moves linearly;
# whose pair is too fast, with a hum; the same, which a stiffness would slow down; the same, beside which a limit was found that is never met; records with
# gaps in coloured noise, of which a damped mode takes a little.
MODELS_FAR_OFF = (220099,)
MORE_MODELS_FAR_OFF = (220097, 230096, 230115, 240013, 500051)
# The same in slow noise: the search of the base alone ended where it took its own error for noise, and that of a mode beside it at the true base.
IN_SLOW_NOISE = (450014,)
# A mode that rings as a stretch of its record begins, as parts between gaps begin, and across a slip of the sensor.
RINGING = (*slow(220142, 220161), 220345)
# The same on a piezo stage whose records ring on where the command rests.
RINGING_AT_REST = slow(700322)
LEAST_ENR = 2.0
LEAST_CLOSED = 0.9  # what the tenth percentile of a large run has to reach
# The product steps its FMU through the commands that it read, which have 7 digits, and so does this test.
RELATIVE_DIFFERENCE = 1e-6

pytestmark = product.needs_program()


@pytest.mark.parametrize("seed", [*SINGLES, *MORE_SINGLES, *FAR_BELOW_DEMAND, *LOADED])
def test_a_plain_effect_is_named_and_the_gap_closes(seed, diagnosed):
    found = diagnosed("single", seed)
    assert found.truth["enr"] > LEAST_ENR, "the seed no longer draws a strong effect: choose another"
    assert found.score["outcome"] in ("right", "first"), found.score
    assert found.score["closed"] > LEAST_CLOSED


@pytest.mark.parametrize("seed", [301052, *slow(301157)])
def test_a_lag_and_a_pole_that_explain_as_much_are_both_said(seed, diagnosed):
    found = diagnosed("single", seed)
    assert found.truth["truth"] == ["sensor_lag"], "the seed no longer draws this: choose another"
    (effect,) = found.diagnosis["effects"]
    assert found.diagnosis["verdict"] == "ambiguous" and effect["name"] == LAGS[seed]
    assert {effect["name"], *effect["alternatives"]} == {"parameter_shift", "sensor_lag"}


@pytest.mark.parametrize("seed", COARSE_SENSORS)
def test_a_coarse_sensor_is_named(seed, diagnosed):
    found = diagnosed("single", seed)
    (effect,) = found.diagnosis["effects"]
    assert found.diagnosis["verdict"] == "named" and effect["name"] == "quantisation"
    true = found.truth["effects"]["quantisation"]["step"]
    assert effect["parameters"]["step"]["value"] == pytest.approx(true, rel=0.02)


@pytest.mark.parametrize("seed", [*CLEAN, *MORE_CLEAN])
def test_nothing_is_named_where_nothing_is(seed, diagnosed):
    found = diagnosed("clean", seed)
    assert found.score["outcome"] in ("nothing_missing", "unexplained") and not found.score["named"]
    assert found.diagnosis["verdict"] == "nothing_missing"


@pytest.mark.parametrize("seed", OUTSIDE)
def test_what_no_effect_describes_is_not_named(seed, diagnosed):
    assert not diagnosed("outside", seed).score["named"]


@pytest.mark.parametrize("seed", TURBULENT)
def test_what_is_left_and_changes_slowly_is_said_to_be_slow_noise_or_a_disturbance(seed, diagnosed):
    white = next(found for found in (diagnosed("clean", seed) for seed in CLEAN) if found.truth["noise"]["kind"] == "white")
    both = diagnosed("outside", seed), white
    assert [any("changes slowly" in note for note in found.diagnosis["notes"]) for found in both] == [True, False]
    sentences = [found.diagnosis["sentence"] for found in both if found.diagnosis["verdict"] == "nothing_missing"]
    assert ["disturbance" in sentence for sentence in sentences] == [True, False][-len(sentences) :], sentences


@pytest.mark.parametrize("seed", PAIRS)
def test_two_plain_effects_are_both_named(seed, diagnosed):
    found = diagnosed("pair", seed)
    assert found.truth["enr"] > LEAST_ENR, "the seed no longer draws two strong effects: choose another"
    assert found.score["outcome"] in ("right", "first"), found.score


@pytest.mark.parametrize("seed", TRIPLES)
def test_three_plain_effects_are_all_named(seed, tmp_path):
    truth, arguments = product.write_case("triple", seed, tmp_path)
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    score = scoring.score(truth, diagnosis)
    assert score["outcome"] == "right" and score["closed"] > LEAST_CLOSED, score


@pytest.mark.parametrize("seed", HEALTHY_RIGS)
def test_a_healthy_rig_gets_no_name(seed, tmp_path):
    _, arguments = product.write_case("rig_healthy", seed, tmp_path)
    assert product.diagnose(product.program(), tmp_path, arguments=arguments)[0]["verdict"] == "unexplained"


def leads_beside_friction(seed, folder):
    """What is listed, and does not lead, on a healthy rig that has friction."""
    truth, arguments = product.write_case("rig_healthy", seed, folder)
    assert "coulomb_friction" in truth["inherent"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), folder, arguments=arguments)
    assert diagnosis["verdict"] == "unexplained"
    return diagnosis["leads"]


@pytest.mark.parametrize("seed", RUBBING_RIGS)
def test_friction_that_any_rig_has_is_listed_and_does_not_lead(seed, tmp_path):
    lead = next(lead for lead in leads_beside_friction(seed, tmp_path) if lead["name"] == "coulomb_friction")
    of_base, taken = map(int, re.search(r"takes (\d+) % of the difference's variance, and this (\d+) %", lead["why_not"]).groups())
    assert lead["share"] > 0.5 and of_base > 70 and taken < 20


@pytest.mark.parametrize(("kind", "seed"), HELD_BY_GIVEN_MODEL)
def test_hysteresis_that_takes_nothing_in_the_given_model_leads_and_may_be_of_before(kind, seed, tmp_path):
    truth, arguments = product.write_case(kind, seed, tmp_path)
    assert "coulomb_friction" in truth["inherent"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert diagnosis["verdict"] == "leading" and [effect["family"] for effect in diagnosis["effects"]] == ["play"], diagnosis["sentence"]
    assert diagnosis["gap"]["after"]["check_rms"] < 0.5 * diagnosis["gap"]["before"]["check_rms"]
    assert any(note.startswith(f"{diagnosis['effects'][0]['name']} takes nothing of the difference in the given model") for note in diagnosis["notes"])


@pytest.mark.parametrize(("seed", "effect"), BESIDE_A_BASE_OF_ITS_OWN)
def test_play_that_explains_what_no_linear_system_does_leads_beside_a_base_that_takes_most(seed, effect, tmp_path):
    truth, arguments = product.write_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == [effect], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    found = diagnosis["effects"][0]
    assert diagnosis["verdict"] == "leading" and effect in (found["name"], *found["alternatives"]), diagnosis["sentence"]
    assert diagnosis["gap"]["after"]["check_rms"] < 0.5 * diagnosis["gap"]["before"]["check_rms"]


@pytest.mark.parametrize("seed", SLIGHTLY_RUBBING_RIGS)
def test_friction_that_leaves_most_of_the_check_records_is_listed(seed, tmp_path):
    leads = leads_beside_friction(seed, tmp_path)
    said = [re.search(r"acts in all motion, and leaves (\d+) % .* check records", lead["why_not"]) for lead in leads]
    assert any(match and int(match[1]) > 50 for match in said)


@pytest.mark.parametrize("seed", STICKING_ON_PARTS)
def test_of_what_holds_on_parts_of_the_records_it_is_said_why_it_does_not_on_the_whole_ones(seed, tmp_path):
    """The numbers said are the rms that the given model leaves of a check record, worked out here from a simulation, and one above it."""
    truth, arguments = product.write_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == ["coulomb_friction"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    reasons = [lead["why_not"] for lead in diagnosis["leads"]]
    said = [re.search(r"not on the whole ones: .* leaves ([\d.]+) deg rms on (\S+), where the given model leaves ([\d.]+) deg", reason) for reason in reasons]
    after, record, before = next(match for match in said if match).groups()
    subprocess.run([product.program(), "simulate", "model.toml", record, "-o", "of_the_model.csv"], cwd=tmp_path, check=True, capture_output=True)
    measured, simulated = (np.loadtxt(tmp_path / name, delimiter=",", skiprows=1) for name in (record, "of_the_model.csv"))
    rms = np.sqrt(np.mean((measured[:, 2] - simulated[: len(measured), 2]) ** 2))
    assert float(before) == pytest.approx(rms, rel=0.02) and float(after) > float(before)


@pytest.mark.parametrize("seed", STICKING_RIGS)
def test_an_effect_leads_only_where_more_is_missing_than_in_the_healthy_reference(seed, tmp_path):
    truth, arguments = product.write_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == ["coulomb_friction"], "the seed no longer draws this: choose another"
    *others, last = arguments
    verdicts, reasons = {}, {}
    # One record that sticks as well, and one that the model describes.
    simulated = [product.program(), "simulate", "model.toml", last, "-o", "of_the_model.csv"]
    subprocess.run(simulated, cwd=tmp_path, check=True, capture_output=True)
    for reference in (last, "of_the_model.csv"):
        diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=[*others, "--reference", reference])
        verdicts[reference] = diagnosis["verdict"]
        reasons[reference] = [lead["why_not"] for lead in diagnosis["leads"]]
        shutil.rmtree(tmp_path / "diagnosis")
    assert verdicts == {last: "unexplained", "of_the_model.csv": "leading"}
    assert any("what is missing has not changed" in reason for reason in reasons[last])


def leading(seed, effect, folder):
    """What leads on a rig with this effect, which is that one: its numbers, the true ones, and the part of the check records' rms that stays."""
    truth, arguments = product.write_case("rig_effect", seed, folder)
    diagnosis, _ = product.diagnose(product.program(), folder, arguments=arguments)
    (found,) = diagnosis["effects"]
    assert diagnosis["verdict"] == "leading" and [found["name"]] == truth["truth"] == [effect]
    gap = diagnosis["gap"]
    return found["parameters"], truth["effects"][effect], gap["after"]["check_rms"] / gap["before"]["check_rms"]


@pytest.mark.parametrize("seed", [*LATE_RIGS, *NEARLY_ALL_LATE])
def test_a_delay_leads_on_a_rig_of_another_structure(seed, tmp_path):
    found, true, left = leading(seed, "delay", tmp_path)
    assert found["time"]["value"] == pytest.approx(true["time"], rel=0.2) and left < 0.5


@pytest.mark.parametrize("seed", LIMITED_RIGS)
def test_a_limit_leads_where_most_of_the_difference_is_another_base(seed, tmp_path):
    found, true, left = leading(seed, "position_limit", tmp_path)
    assert found["max"]["value"] == pytest.approx(true["max"], rel=0.05) and left < 0.7


@pytest.mark.parametrize("seed", STOPPED_RIGS)
def test_a_stop_leads_at_the_level_at_which_positions_stand(seed, tmp_path):
    found, true, left = leading(seed, "position_limit", tmp_path)
    assert [found[side]["value"] for side in ("min", "max")] == pytest.approx([true["min"], true["max"]], rel=0.05) and left < 0.3


@pytest.mark.parametrize("seed", LIMITED_AND_MORE)
def test_a_limit_leads_that_more_comes_to_in_a_check_record(seed, tmp_path):
    found, true, left = leading(seed, "command_limit", tmp_path)
    assert [found[side]["value"] for side in ("min", "max")] == pytest.approx([true["min"], true["max"]], rel=0.2) and left < 0.6


@pytest.mark.parametrize("seed", UNMET_IN_CHECK)
def test_a_limit_leads_that_a_check_record_does_not_meet(seed, tmp_path):
    found, true, left = leading(seed, "rate_limit", tmp_path)
    assert [found[side]["value"] for side in ("up", "down")] == pytest.approx([true["up"], true["down"]], rel=0.05) and left < 0.5


@pytest.mark.parametrize("seed", LONG_RECORDS)
def test_a_limit_leads_that_stretches_of_long_records_do_not_tell(seed, tmp_path):
    found, true, left = leading(seed, "command_limit", tmp_path)
    assert [found[side]["value"] for side in ("min", "max")] == pytest.approx([true["min"], true["max"]], rel=0.05) and left < 0.5


@pytest.mark.parametrize("seed", LONG_AND_DRIFTING)
def test_a_drift_that_stretches_of_long_records_do_not_tell_is_named(seed, tmp_path):
    truth, arguments = product.write_case("wide", seed, tmp_path)
    assert truth["truth"] == ["sensor_bias"] and truth["model_is_off"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    score = scoring.score(truth, diagnosis)
    assert score["outcome"] == "right" and score["closed"] > LEAST_CLOSED and not score["widened"], score
    drift = diagnosis["effects"][0]["parameters"]["drift"]["value"]
    assert drift == pytest.approx(truth["effects"]["sensor_bias"]["drift"], rel=0.02)


@pytest.mark.parametrize("seed", slow(*ONLY_IN_CHECK))
def test_a_limit_that_only_the_check_record_meets_is_a_suspicion(seed, tmp_path):
    truth, arguments = product.write_case("check_only", seed, tmp_path)
    assert truth["truth"] == [ONLY_IN_CHECK[seed]], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert scoring.score(truth, diagnosis)["outcome"] == "suspected"
    assert diagnosis["verdict"] == "unexplained" and not diagnosis["effects"]
    assert "check.csv" in diagnosis["leads"][0]["only_in"] and "check.csv alone" in diagnosis["sentence"]
    contradicted = [lead["name"] for lead in diagnosis["leads"] if "another effect, suspected there" in lead["why_not"]]
    assert contradicted == CONTRADICTED.get(seed, [])


@pytest.mark.parametrize("seed", slow(*ONLY_IN_CHECK_OF_RIG))
def test_a_limit_of_a_rig_that_only_the_check_record_meets_is_a_suspicion(seed, tmp_path):
    truth, arguments = product.write_case("rig_effect", seed, tmp_path)
    (name,) = truth["truth"]
    assert name == ONLY_IN_CHECK_OF_RIG[seed], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    lead = diagnosis["leads"][0]
    assert diagnosis["verdict"] == "unexplained" and lead["name"] == name and lead["only_in"] in arguments
    assert lead["parameters"]["value"] == pytest.approx(truth["effects"][name]["value"], rel=0.2) and lead["share"] > 0.9


@pytest.mark.parametrize("seed", slow(*LEAVING_MORE))
def test_a_lead_that_leaves_more_of_a_record_is_listed_with_that_record(seed, tmp_path):
    truth, arguments = product.write_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == [LEAVING_MORE[seed]], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert diagnosis["verdict"] == "unexplained" and not diagnosis["effects"]
    lead = diagnosis["leads"][0]
    why_not = re.search(r"leaves (\S+) deg rms on (\S+), where the given model leaves (\S+) deg", lead["why_not"])
    after, record, before = why_not.groups()
    assert lead["name"] == LEAVING_MORE[seed] and record in arguments and float(after) > float(before)


@pytest.mark.parametrize("seed", OVERLAPPED_RIGS)
def test_a_dead_zone_leads_where_the_base_holds_the_position_off_its_command(seed, tmp_path):
    found, true, left = leading(seed, "command_dead_zone", tmp_path)
    assert found["half_width"]["value"] == pytest.approx(true["half_width"], rel=0.1) and left < 0.3


@pytest.mark.parametrize("seed", slow(*OF_SENSOR))
def test_what_a_sensor_adds_leads_on_a_rig_of_another_structure(seed, tmp_path):
    truth, arguments = product.write_case("rig_sensor", seed, tmp_path)
    assert truth["truth"] == [OF_SENSOR[seed]], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    score = scoring.score(truth, diagnosis)
    gap = diagnosis["gap"]
    assert score["named"] == truth["truth"] and score["strength_right"]
    assert gap["after"]["check_rms"] < gap["before"]["check_rms"]


@pytest.mark.parametrize("seed", HEAVILY_DAMPED_DRIVE)
def test_a_heavily_damped_model_under_an_uneven_clock_is_searched_in_time(seed, tmp_path):
    truth, arguments = product.write_case("drive", seed, tmp_path)
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert scoring.score(truth, diagnosis)["outcome"] in ("nothing_missing", "unexplained", "inherent")


@pytest.mark.parametrize("seed", INDEPENDENT_HEALTHY)
def test_a_healthy_rig_with_a_sensor_of_its_own_gets_no_name_but_of_what_acts_in_it(seed, tmp_path):
    truth, arguments = product.write_case("independent", seed, tmp_path)
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert scoring.score(truth, diagnosis)["outcome"] in ("nothing_missing", "unexplained", "inherent")


@pytest.mark.parametrize("seed", INDEPENDENT_EFFECTS)
def test_an_effect_of_a_rig_with_a_sensor_of_its_own_is_told_with_its_strength(seed, tmp_path):
    truth, arguments = product.write_case("independent_effect", seed, tmp_path)
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    score = scoring.score(truth, diagnosis)
    assert score["named"] == truth["truth"] == ["asymmetric_gain"], "or the seed no longer draws this effect: choose another"
    assert score["strength_right"] and not score["widened"]


@pytest.mark.parametrize("seed", INDEPENDENT_LATE)
def test_what_a_base_alone_explains_better_gets_no_other_name(seed, tmp_path):
    truth, arguments = product.write_case("independent_effect", seed, tmp_path)
    assert truth["truth"] == ["delay"], "the seed no longer draws this effect: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert {effect["name"] for effect in diagnosis["effects"]} <= {"delay"}


@pytest.mark.parametrize("seed", slow(*DECLARED_WRONGLY))
def test_a_command_declared_wrongly_is_no_effect(seed, tmp_path):
    truth, arguments = product.write_case("nuisance", seed, tmp_path)
    assert truth["hold"] != truth["declared_hold"] and not truth["truth"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert scoring.score(truth, diagnosis)["outcome"] == "nothing_missing", "but for the model, which may be off"
    assert any(DECLARED_WRONGLY[seed] in warning for warning in diagnosis["warnings"])


MORE_FAR_OFF = [*(("nuisance", seed) for seed in MORE_MODELS_FAR_OFF), *(("wide_clean", seed) for seed in IN_SLOW_NOISE)]


@pytest.mark.parametrize("kind, seed", [*(("nuisance", seed) for seed in MODELS_FAR_OFF), *slow(*MORE_FAR_OFF)])
def test_a_model_that_is_far_off_lacks_no_effect(kind, seed, tmp_path):
    truth, arguments = product.write_case(kind, seed, tmp_path)
    assert truth["model_is_off"] and not truth["truth"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    assert scoring.score(truth, diagnosis)["outcome"] == "nothing_missing"
    assert diagnosis["base"]["after"]["omega"] == pytest.approx(truth["base"]["omega"], rel=0.05)


@pytest.mark.parametrize("seed", RINGING)
def test_a_mode_that_rings_as_a_record_begins_is_named(seed, tmp_path):
    tells_mode("nuisance", seed, tmp_path)


@pytest.mark.parametrize("seed", RINGING_AT_REST)
def test_a_mode_that_rings_on_where_the_command_rests_leads(seed, tmp_path):
    tells_mode("drive_effect", seed, tmp_path)


def tells_mode(kind, seed, tmp_path):
    truth, arguments = product.write_case(kind, seed, tmp_path)
    assert truth["truth"] == ["structural_mode"], "the seed no longer draws this: choose another"
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    (effect,) = diagnosis["effects"]
    assert effect["name"] == "structural_mode"
    frequency = truth["effects"]["structural_mode"]["frequency"]
    assert effect["parameters"]["frequency"]["value"] == pytest.approx(frequency, rel=0.01)


@pytest.mark.parametrize("kind, seed", [("single", SINGLES[0]), ("clean", CLEAN[0])])
def test_the_noise_is_told_from_the_gap(kind, seed, diagnosed):
    assert diagnosed(kind, seed).score["noise_ratio"] == pytest.approx(1.0, abs=0.2)


def test_the_fmu_written_leaves_the_gap_that_is_stated(diagnosed):
    """model.fmu, loaded in fmpy and stepped through the check record as it was written to disk, from where the diagnosis says."""
    found = diagnosed("single", SINGLES[0])
    out = found.folder / "diagnosis"
    assert (out / "model.toml").is_file() and (out / "report.html").stat().st_size > 1000
    diagnosis = json.loads((out / "diagnosis.json").read_text())
    (record,) = (record for record in diagnosis["records"] if record["role"] == "check")
    time, command, position = read_record(found.folder / "check.csv")
    with unpacked(out / "model.fmu") as package, Actuator(package) as actuator:
        actuator.restart({"initial_position": record["initial_position"]} | record["own_values"])
        simulated = np.concatenate([[actuator["position"]], actuator.run(command[:-1], np.diff(time))])
    gap = np.sqrt(np.mean((position - simulated)[record["samples_not_counted"] :] ** 2))
    assert gap == pytest.approx(diagnosis["gap"]["after"]["check_rms"], rel=RELATIVE_DIFFERENCE)
    assert gap == pytest.approx(found.truth["noise_rms"], rel=0.2)


def read_record(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return (np.array([float(row[name]) for row in rows]) for name in ("time", "command", "position"))
