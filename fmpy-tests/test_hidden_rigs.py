"""A small part of the hidden-effect suite, rigs with another structure than the model: which effects lead, which are listed, and the verdict on healthy rigs.

The cases are drawn by `hidden/`; `test_hidden_effects.py` has those of the model's own structure.
"""

import re
import shutil
import subprocess

import numpy as np
import pytest

from hidden import product, scoring
from hidden.product import slow

# Of another structure. Healthy: a linear base explains as much as any effect beside a linear model; a dead zone of a different width in each
# record would be a small part of the difference. With a delay: friction and an equally late base explain more; the model was fitted to late records.
HEALTHY_RIGS = (*slow(170008), 240010)
# A rig whose free base explains four fifths of the difference, and friction half of the remainder.
RUBBING_RIGS = slow(675022)
# Play, and friction of a rig with a level, which are all, or most, of what no linear system explains; a free base explains most of the difference.
BESIDE_A_BASE_OF_ITS_OWN = slow((672003, "backlash"), (678064, "coulomb_friction"))
# Play on a rig where a lag explains more, but is contradicted by a check record.
BESIDE_A_CONTRADICTED_LAG = slow(696031)
# Geared rigs with friction, with and without play, whose given model is in error, or was fitted to them: hysteresis explains most of the difference.
HELD_BY_GIVEN_MODEL = (("rig_effect", 672007), *slow(("rig_healthy", 675010)))
HELD_AND_HEALTHY_RECORDED = slow(672007)
# Friction with which most of the difference on the check records remains.
SLIGHTLY_RUBBING_RIGS = slow(460075)
# Friction that explains parts of the records, and whose simulation has a larger residual on a whole one, level included, than the model without it.
STICKING_ON_PARTS = slow(651030)
# Friction that is most of the difference.
STICKING_RIGS = slow(330168)
LATE_RIGS = slow(160018, 160009)
# A delay with which a four-hundredth of the difference remains; with a slow base a third less remains.
NEARLY_ALL_LATE = slow(430041)
# A limit that explains more on parts of the records as found, and on whole ones after a refit.
LIMITED_RIGS = slow(180003)
# A limit of the command's rate that saturates for less than a lag and explains nearly all that no linear system does.
BRIEFLY_LIMITED_RIGS = slow(729209)
# Play in records of which one has a larger residual than with the given model, beside its own base and beside the given one.
PLAY_BESIDE_CHANGING_BASES = slow(720058)
# A stop at which positions rest, on a rig whose model has too small a gain to reach it.
STOPPED_RIGS = slow(600186)
# A limit in addition to which friction and a lag are suspected; one in a trapezoid, where it begins to act within a sample, like a slip of the sensor.
LIMITED_AND_MORE = slow(430032, 450114)
# A limit that a check record does not reach: there the model with it differs from the given one by rounding alone.
UNMET_IN_CHECK = slow(450001)
# A valve with overlap, and a position with a level in all records.
OVERLAPPED_RIGS = slow(240004)
# Long records, whose stretches do not show the effect that leads on the whole ones.
LONG_RECORDS = slow(260014)
# The same on a rig of another structure, where the base of the fit records gives another limit.
ONLY_IN_CHECK_OF_RIG = {500206: "acceleration_limit"}
# A limit that explains nearly all of the difference on unseen records, but increases the residual of one of them above that of the given model.
LEAVING_MORE = {320023: "acceleration_limit"}
# Drifting biases, one of which makes a staircase correlate best with steps of other signs, and hums, one of which a hardly damped mode explains equally
# well, on rigs of another structure.
OF_SENSOR = {540015: "sensor_bias", 540036: "chatter", 662006: "chatter", 662016: "chatter", 663003: "sensor_bias", 663009: "sensor_bias", 664010: "sensor_bias"}
# A loop that nearly oscillates because of an acceleration limit, like a mode with a damping ratio of a millionth.
RINGING_FOR_HOURS = (702099,)
# A healthy electro-hydrostatic drive, on whose records of 15 s a line of 0.136 Hz explained as much as another base.
SLOWLY_OFF = (699024,)
# With separate sensors and loggers: a stepper behind an encoder; a servo with a smaller gain for negative commands.
INDEPENDENT_HEALTHY = slow(11)
INDEPENDENT_EFFECTS = slow(300003)
# A servo valve with a delay: the residual of a base alone on the check record is far smaller than that of a limit.
INDEPENDENT_LATE = slow(310027)
# A healthy harmonic drive with an uneven clock, whose model of order 2 has a damping ratio of 16.
HEAVILY_DAMPED_DRIVE = slow(700340)

pytestmark = product.needs_program()


def of_the_model(record, folder):
    """A record that the given model describes: its simulated motion under the commands of this one."""
    simulated = "of_the_model.csv"
    subprocess.run([product.program(), "simulate", "model.toml", record, "-o", simulated], cwd=folder, check=True, capture_output=True)
    return simulated


@pytest.mark.parametrize("seed", HEALTHY_RIGS)
def test_a_healthy_rig_gets_no_name(seed, tmp_path):
    _, diagnosis = product.diagnose_case("rig_healthy", seed, tmp_path)
    assert diagnosis["verdict"] == "unexplained"


def leads_beside_friction(seed, folder):
    """Effects that are listed, and do not lead, on a healthy rig with friction."""
    truth, diagnosis = product.diagnose_case("rig_healthy", seed, folder)
    assert "coulomb_friction" in truth["inherent"], "the seed no longer draws this: choose another"
    assert diagnosis["verdict"] == "unexplained"
    return diagnosis["leads"]


@pytest.mark.parametrize("seed", RUBBING_RIGS)
def test_friction_that_any_rig_has_is_listed_and_does_not_lead(seed, tmp_path):
    lead = next(lead for lead in leads_beside_friction(seed, tmp_path) if lead["name"] == "coulomb_friction")
    of_base, taken = map(int, re.search(r"explains (\d+) % of the variance of the difference, the effect (\d+) % more", lead["why_not"]).groups())
    assert lead["share"] > 0.5 and of_base > 70 and taken < 20


@pytest.mark.parametrize(("kind", "seed"), HELD_BY_GIVEN_MODEL)
def test_hysteresis_that_takes_nothing_in_the_given_model_leads_and_may_be_of_before(kind, seed, tmp_path):
    truth, diagnosis = product.diagnose_case(kind, seed, tmp_path)
    assert "coulomb_friction" in truth["inherent"], "the seed no longer draws this: choose another"
    assert diagnosis["verdict"] == "leading" and [effect["family"] for effect in diagnosis["effects"]] == ["play"], diagnosis["sentence"]
    assert diagnosis["gap"]["after"]["check_rms"] < 0.5 * diagnosis["gap"]["before"]["check_rms"]
    assert need_not_be_new(diagnosis)


def need_not_be_new(diagnosis):
    lead = diagnosis["effects"][0]["name"]
    return any(note.startswith(f"{lead} explains hardly any of the difference in the given model") for note in diagnosis["notes"])


@pytest.mark.parametrize("seed", HELD_AND_HEALTHY_RECORDED)
def test_a_healthy_reference_answers_whether_hysteresis_is_new(seed, tmp_path):
    _, arguments = product.write_case("rig_effect", seed, tmp_path)
    reference = of_the_model(arguments[-1], tmp_path)
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=[*arguments, "--reference", reference])
    assert diagnosis["verdict"] == "leading" and diagnosis["effects"][0]["family"] == "play", diagnosis["sentence"]
    assert not need_not_be_new(diagnosis)


@pytest.mark.parametrize(("seed", "effect"), BESIDE_A_BASE_OF_ITS_OWN)
def test_play_that_explains_what_no_linear_system_does_leads_beside_a_base_that_takes_most(seed, effect, tmp_path):
    truth, diagnosis = product.diagnose_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == [effect], "the seed no longer draws this: choose another"
    found = diagnosis["effects"][0]
    assert diagnosis["verdict"] == "leading" and effect in (found["name"], *found["alternatives"]), diagnosis["sentence"]
    assert diagnosis["gap"]["after"]["check_rms"] < 0.5 * diagnosis["gap"]["before"]["check_rms"]


@pytest.mark.parametrize("seed", SLIGHTLY_RUBBING_RIGS)
def test_friction_that_leaves_most_of_the_check_records_is_listed(seed, tmp_path):
    leads = leads_beside_friction(seed, tmp_path)
    said = [re.search(r"acts in all motion, but (\d+) % .* check records", lead["why_not"]) for lead in leads]
    assert any(match and int(match[1]) > 50 for match in said)


@pytest.mark.parametrize("seed", STICKING_ON_PARTS)
def test_of_what_holds_on_parts_of_the_records_it_is_said_why_it_does_not_on_the_whole_ones(seed, tmp_path):
    """The reported numbers are the rms of the given model's residual on a check record, computed here from a simulation, and a larger one."""
    truth, diagnosis = product.diagnose_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == ["coulomb_friction"], "the seed no longer draws this: choose another"
    reasons = [lead["why_not"] for lead in diagnosis["leads"]]
    said = [re.search(r"not on the whole ones: .* residual of ([\d.]+) deg rms on (\S+), the given model ([\d.]+) deg", reason) for reason in reasons]
    after, record, before = next(match for match in said if match).groups()
    measured, simulated = (np.loadtxt(tmp_path / name, delimiter=",", skiprows=1) for name in (record, of_the_model(record, tmp_path)))
    rms = np.sqrt(np.mean((measured[:, 2] - simulated[: len(measured), 2]) ** 2))
    assert float(before) == pytest.approx(rms, rel=0.02) and float(after) > float(before)


@pytest.mark.parametrize("seed", STICKING_RIGS)
def test_an_effect_leads_only_where_more_is_missing_than_in_the_healthy_reference(seed, tmp_path):
    truth, arguments = product.write_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == ["coulomb_friction"], "the seed no longer draws this: choose another"
    *others, last = arguments
    verdicts, reasons = {}, {}
    # Another record with sticking, and one that the model describes.
    for reference in (last, of_the_model(last, tmp_path)):
        diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=[*others, "--reference", reference])
        verdicts[reference] = diagnosis["verdict"]
        reasons[reference] = [lead["why_not"] for lead in diagnosis["leads"]]
        shutil.rmtree(tmp_path / "diagnosis")
    assert verdicts == {last: "unexplained", "of_the_model.csv": "leading"}
    assert any("what is missing has not changed" in reason for reason in reasons[last])


def leading(seed, effect, folder):
    """The effect that leads on a rig with this effect, which is the same one: its numbers, the true ones, and the remaining share of the check records' rms."""
    truth, diagnosis = product.diagnose_case("rig_effect", seed, folder)
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


@pytest.mark.parametrize("seed", BRIEFLY_LIMITED_RIGS)
def test_a_limit_that_saturates_for_less_than_a_lag_leads_where_it_explains_nearly_all(seed, tmp_path):
    found, true, left = leading(seed, "command_rate_limit", tmp_path)
    assert found["up"]["value"] == pytest.approx(true["up"], rel=0.1) and left < 0.7


@pytest.mark.parametrize("seed", PLAY_BESIDE_CHANGING_BASES)
def test_play_leads_beside_a_base_between_those_of_the_records_and_the_given_one(seed, tmp_path):
    _, _, left = leading(seed, "backlash", tmp_path)
    assert left < 0.7


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
    truth, diagnosis = product.diagnose_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == [LEAVING_MORE[seed]], "the seed no longer draws this: choose another"
    assert diagnosis["verdict"] == "unexplained" and not diagnosis["effects"]
    lead = diagnosis["leads"][0]
    why_not = re.search(r"residual of (\S+) deg rms on (\S+), the given model (\S+) deg", lead["why_not"])
    after, record, before = why_not.groups()
    assert lead["name"] == LEAVING_MORE[seed] and (tmp_path / record).is_file() and float(after) > float(before)


@pytest.mark.parametrize("seed", OVERLAPPED_RIGS)
def test_a_dead_zone_leads_where_the_base_holds_the_position_off_its_command(seed, tmp_path):
    found, true, left = leading(seed, "command_dead_zone", tmp_path)
    assert found["half_width"]["value"] == pytest.approx(true["half_width"], rel=0.1) and left < 0.3


@pytest.mark.parametrize("seed", slow(*OF_SENSOR))
def test_what_a_sensor_adds_leads_on_a_rig_of_another_structure(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("rig_sensor", seed, tmp_path)
    assert truth["truth"] == [OF_SENSOR[seed]], "the seed no longer draws this: choose another"
    score = scoring.score(truth, diagnosis)
    gap = diagnosis["gap"]
    assert score["named"] == truth["truth"] and score["strength_right"]
    assert gap["after"]["check_rms"] < gap["before"]["check_rms"]


@pytest.mark.parametrize("seed", HEAVILY_DAMPED_DRIVE)
def test_a_heavily_damped_model_under_an_uneven_clock_is_searched_in_time(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("drive", seed, tmp_path)
    assert scoring.score(truth, diagnosis)["outcome"] in ("nothing_missing", "unexplained", "inherent")


@pytest.mark.parametrize("seed", BESIDE_A_CONTRADICTED_LAG)
def test_an_effect_leads_where_the_lag_before_it_is_contradicted(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == ["backlash"], "the seed no longer draws this effect: choose another"
    assert diagnosis["verdict"] == "leading" and [effect["name"] for effect in diagnosis["effects"]] == ["backlash"]
    assert diagnosis["gap"]["after"]["check_rms"] < 0.3 * diagnosis["gap"]["before"]["check_rms"]


@pytest.mark.parametrize("seed", slow(*RINGING_FOR_HOURS))
def test_a_resonance_without_damping_is_no_structure(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("rig_effect", seed, tmp_path)
    assert truth["truth"] == ["acceleration_limit"], "the seed no longer draws this effect: choose another"
    assert "structural_mode" not in [effect["name"] for effect in diagnosis["effects"]]


@pytest.mark.parametrize("seed", slow(*SLOWLY_OFF))
def test_a_line_of_two_periods_is_no_oscillation(seed, tmp_path):
    _, diagnosis = product.diagnose_case("drive", seed, tmp_path)
    assert diagnosis["verdict"] == "unexplained" and not diagnosis["effects"]


@pytest.mark.parametrize("seed", INDEPENDENT_HEALTHY)
def test_a_healthy_rig_with_a_sensor_of_its_own_gets_no_name_but_of_what_acts_in_it(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("independent", seed, tmp_path)
    assert scoring.score(truth, diagnosis)["outcome"] in ("nothing_missing", "unexplained", "inherent")


@pytest.mark.parametrize("seed", INDEPENDENT_EFFECTS)
def test_an_effect_of_a_rig_with_a_sensor_of_its_own_is_told_with_its_strength(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("independent_effect", seed, tmp_path)
    score = scoring.score(truth, diagnosis)
    assert score["named"] == truth["truth"] == ["asymmetric_gain"], "or the seed no longer draws this effect: choose another"
    assert score["strength_right"] and not score["widened"]


@pytest.mark.parametrize("seed", INDEPENDENT_LATE)
def test_what_a_base_alone_explains_better_gets_no_other_name(seed, tmp_path):
    truth, diagnosis = product.diagnose_case("independent_effect", seed, tmp_path)
    assert truth["truth"] == ["delay"], "the seed no longer draws this effect: choose another"
    assert {effect["name"] for effect in diagnosis["effects"]} <= {"delay"}
