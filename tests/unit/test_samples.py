"""Nothing is dropped when measurements enter: what is wrong with a sample is flagged."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import SampleError, UsageError
from brdfit.samples import Flag, Samples, Source, default_channels

UP = (0.0, 0.0, 1.0)
TILTED = (0.6, 0.0, 0.8)
DOWN = (0.6, 0.0, -0.8)
LEVEL = (1.0, 0.0, 0.0)


def one(wi: object = UP, wo: object = TILTED, value: object = (0.1, 0.2, 0.3)) -> Samples:
    return Samples(
        wi=np.array([wi], float), wo=np.array([wo], float), value=np.array([value], float)
    )


@pytest.fixture
def five(random_directions: Callable[[int], tuple[FloatArray, FloatArray]]) -> Samples:
    """Five samples, three bands, one censored, one partly missing, one stated to be wrong."""
    wi, wo = random_directions(5)
    value = np.arange(1.0, 16.0).reshape(5, 3)
    value[1, 2], value[3, 0] = -1.0, np.nan
    return Samples(
        wi=wi,
        wo=wo,
        value=value,
        sigma=0.1 * np.abs(value),
        wavelengths=np.array([450.0, 550.0, 650.5]),
        flags=np.array([0, 0, 0, 0, Flag.REJECTED]),
        rows=np.arange(10, 15),
        source=Source(name="five.csv"),
    )


def test_a_good_sample_has_no_flag_and_is_used() -> None:
    samples = one()
    assert samples.bits.tolist() == [0]
    assert samples.flag_counts() == {}
    assert samples.usable.all()
    assert samples.positive.all()


@pytest.mark.parametrize(
    ("arguments", "flag"),
    [
        ({"value": (np.nan, np.nan, np.inf)}, Flag.NOT_FINITE),
        ({"wi": (np.nan, 0.0, 1.0)}, Flag.NOT_FINITE),
        ({"wo": (np.inf, 0.0, 1.0)}, Flag.NOT_FINITE),
        ({"wi": DOWN}, Flag.BELOW_HORIZON),
        ({"wo": LEVEL}, Flag.BELOW_HORIZON),
        ({"wi": (0.0, 0.0, 1.002)}, Flag.NOT_UNIT),
        ({"wo": (0.0, 0.0, 1e-9)}, Flag.NOT_UNIT),
    ],
)
def test_what_cannot_be_used_is_flagged_and_not_used(
    arguments: dict[str, object], flag: Flag
) -> None:
    samples = one(**arguments)
    assert Flag(int(samples.bits[0])) == flag
    assert not samples.usable.any()
    assert samples.flag_counts() == {str(flag.name).lower(): 1}


@pytest.mark.parametrize("flag", [Flag.UNREADABLE, Flag.REJECTED])
def test_what_was_stated_to_be_wrong_is_not_used(flag: Flag) -> None:
    stated = one().with_flags([True], flag)
    assert Flag(int(stated.bits[0])) == flag
    assert not stated.usable.any()


@pytest.mark.parametrize("low", [0.0, -0.5])
def test_a_value_at_or_under_zero_is_censored_and_used(low: float) -> None:
    samples = one(value=(0.1, low, 0.3))
    assert Flag(int(samples.bits[0])) == Flag.CENSORED
    assert samples.usable.tolist() == [[True, True, True]]
    assert samples.censored.tolist() == [[False, True, False]]
    assert samples.positive.tolist() == [[True, False, True]]


@pytest.mark.parametrize("lost", [np.nan, np.inf, -np.inf])
def test_a_channel_that_is_missing_leaves_the_others_in_use(lost: float) -> None:
    samples = one(value=(0.1, lost, 0.3))
    assert Flag(int(samples.bits[0])) == Flag.PARTLY_MISSING
    assert samples.usable.tolist() == [[True, False, True]]


def test_every_flag_has_a_test_here() -> None:
    assert {flag.name for flag in Flag} == {
        "NOT_FINITE",
        "BELOW_HORIZON",
        "NOT_UNIT",
        "CENSORED",
        "PARTLY_MISSING",
        "DUPLICATE",
        "UNREADABLE",
        "REJECTED",
    }


def test_a_repeated_direction_is_flagged_from_the_second_on_and_used() -> None:
    wi = np.array([UP, UP, TILTED, UP])
    wo = np.array([TILTED, TILTED, UP, TILTED])
    samples = Samples(wi=wi, wo=wo, value=np.ones(4))
    # light and detector exchanged is another measurement
    assert (samples.bits & Flag.DUPLICATE > 0).tolist() == [False, True, False, True]
    assert samples.usable.all()


def test_directions_a_milliradian_apart_are_not_repeated() -> None:
    angle = np.array([0.5, 0.501, 0.5 + 1e-6])
    wi = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    samples = Samples(wi=wi, wo=np.array([UP] * 3), value=np.ones(3))
    assert samples.flag_counts() == {"duplicate": 1}


def test_a_direction_that_is_not_finite_makes_no_other_sample_a_repetition() -> None:
    wi = np.array([(np.nan, 0.0, 1.0), UP, (np.nan, 0.0, 1.0)])
    samples = Samples(wi=wi, wo=np.array([UP] * 3), value=np.ones(3))
    assert samples.flag_counts() == {"not_finite": 2}


def test_flags_that_follow_from_the_numbers_cannot_be_stated() -> None:
    with pytest.raises(UsageError, match="only UNREADABLE and REJECTED can be stated"):
        one().with_flags([True], Flag.CENSORED)
    given = Samples(
        wi=np.array([UP]), wo=np.array([UP]), value=np.ones(1), flags=np.array([int(Flag.CENSORED)])
    )
    assert given.flag_counts() == {}


def test_with_flags_adds_to_what_was_there(five: Samples) -> None:
    more = five.with_flags([True, False, False, False, True], Flag.UNREADABLE)
    assert more.flag_counts() == {
        "censored": 1,
        "partly_missing": 1,
        "unreadable": 2,
        "rejected": 1,
    }
    assert five.flag_counts()["rejected"] == 1
    assert "unreadable" not in five.flag_counts()


@pytest.mark.parametrize("name", ["wi", "wo", "value", "sigma", "flags", "rows", "wavelengths"])
def test_the_arrays_cannot_be_written(five: Samples, name: str) -> None:
    with pytest.raises(ValueError, match="read-only"):
        getattr(five, name)[0] = 0


@pytest.mark.parametrize("name", ["usable", "censored", "positive", "noise_floor"])
def test_what_follows_from_the_arrays_cannot_be_written(five: Samples, name: str) -> None:
    with pytest.raises(ValueError, match="read-only"):
        getattr(five, name)[0] = 0


def test_a_field_cannot_be_set(five: Samples) -> None:
    with pytest.raises(AttributeError):
        five.value = np.zeros((5, 3))  # type: ignore[misc]


def test_the_arrays_given_are_copied() -> None:
    value = np.ones((1, 3))
    samples = Samples(wi=np.array([UP]), wo=np.array([TILTED]), value=value)
    value[0] = 7.0
    assert (samples.value == 1.0).all()


@pytest.mark.parametrize(
    "rows", [[4, 0, 1], np.array([True, True, False, False, True]), [], slice(1, 3)]
)
def test_a_subset_keeps_all_that_belongs_to_its_rows(five: Samples, rows: npt.ArrayLike) -> None:
    index = np.arange(5)[rows] if not isinstance(rows, list) else np.array(rows, int)
    part = five.subset(index if isinstance(rows, slice) else rows)
    assert len(part) == len(index)
    for name in ("wi", "wo", "value", "sigma", "flags", "rows", "usable"):
        np.testing.assert_array_equal(getattr(part, name), getattr(five, name)[index])
    assert (part.channels, part.source) == (five.channels, five.source)


def test_a_permutation_and_its_inverse_change_nothing(
    five: Samples, rng: np.random.Generator
) -> None:
    order = rng.permutation(5)
    back = five.subset(order).subset(np.argsort(order))
    for name in ("wi", "wo", "value", "sigma", "flags", "rows"):
        np.testing.assert_array_equal(getattr(back, name), getattr(five, name))


def test_a_subset_without_the_first_of_a_pair_repeats_nothing() -> None:
    pair = Samples(wi=np.array([UP, UP]), wo=np.array([UP, UP]), value=np.ones(2))
    assert pair.flag_counts() == {"duplicate": 1}
    assert pair.subset([1]).flag_counts() == {}
    assert pair.subset([1, 1]).flag_counts() == {"duplicate": 1}


def test_a_mask_of_the_wrong_length_is_named(five: Samples) -> None:
    with pytest.raises(UsageError, match=r"rows: found shape \(3,\) but there are 5 samples"):
        five.subset([True, False, True])


def test_selected_channels_keep_names_wavelengths_and_sigma(five: Samples) -> None:
    part = five.select_channels([2, 0])
    assert part.channels == ("650.5nm", "450nm")
    assert part.wavelengths is not None
    assert part.wavelengths.tolist() == [650.5, 450.0]
    np.testing.assert_array_equal(part.value, five.value[:, [2, 0]])
    np.testing.assert_array_equal(part.sigma, five.sigma[:, [2, 0]])  # type: ignore[index]


def test_selected_channels_are_judged_by_their_own_values(five: Samples) -> None:
    assert five.select_channels([0]).flag_counts() == {"not_finite": 1, "rejected": 1}
    assert five.select_channels([1]).flag_counts() == {"rejected": 1}
    assert five.select_channels([2]).flag_counts() == {"censored": 1, "rejected": 1}


def test_other_values_are_judged_anew_and_statements_stay(five: Samples) -> None:
    other = five.with_value(np.ones((5, 3)))
    assert other.flag_counts() == {"rejected": 1}
    np.testing.assert_array_equal(other.rows, five.rows)


def test_other_values_are_not_reshaped(five: Samples) -> None:
    with pytest.raises(UsageError, match=r"value: found an array of shape \(3, 5\)"):
        five.with_value(np.ones((3, 5)))
    with pytest.raises(UsageError, match="value: found 2 channels but the values have 3"):
        five.with_value(np.ones((5, 2)))


def test_the_noise_floor_is_the_first_percentile_of_the_positive_values() -> None:
    column = np.concatenate([np.linspace(1.0, 2.0, 101), [0.0, -1.0, np.nan]])
    value = np.stack([column, np.zeros(104)], axis=1)
    directions = np.tile(UP, (104, 1))
    samples = Samples(wi=directions, wo=directions, value=value)
    np.testing.assert_allclose(samples.noise_floor, [1.01, np.nan])


def test_no_samples_at_all_are_a_legal_but_unusable_set() -> None:
    none = Samples(wi=np.zeros((0, 3)), wo=np.zeros((0, 3)), value=np.zeros((0, 3)))
    assert len(none) == 0
    assert np.isnan(none.noise_floor).all()
    with pytest.raises(SampleError, match="found 0 usable samples of 0"):
        none.require_usable()


def test_too_few_usable_samples_say_why(five: Samples) -> None:
    five.require_usable(4)
    with pytest.raises(SampleError) as raised:
        five.require_usable(5)
    message = str(raised.value)
    assert message.startswith("five.csv: found 4 usable samples of 5")
    assert "1 rejected" in message
    assert "1 censored" in message


def test_channels_are_named_by_wavelength_count_or_nothing() -> None:
    assert default_channels(1) == ("value",)
    assert default_channels(3) == ("R", "G", "B")
    assert default_channels(2) == ("channel0", "channel1")
    assert default_channels(2, [400.0, 632.8]) == ("400nm", "632.8nm")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"wi": np.zeros((2, 3))}, "wi has 2 rows but wo has 4"),
        ({"wo": np.zeros((4, 2))}, r"wo: found an array of shape \(4, 2\)"),
        ({"value": np.zeros((3, 3))}, r"value: found an array of shape \(3, 3\)"),
        ({"sigma": np.zeros((4, 2))}, "sigma: found 2 channels but the values have 3"),
        ({"wavelengths": [500.0]}, r"wavelengths of shape \(1,\) but 3 channels"),
        ({"channels": ("R", "G")}, r"2 channel names \('R', 'G'\) but 3 channels"),
        ({"flags": np.zeros(3, int)}, r"flags: found shape \(3,\) but there are 4 samples"),
        ({"rows": np.zeros(5, int)}, r"rows: found shape \(5,\) but there are 4 samples"),
    ],
)
def test_shapes_that_disagree_are_named(arguments: dict[str, object], message: str) -> None:
    good = {"wi": np.tile(UP, (4, 1)), "wo": np.tile(UP, (4, 1)), "value": np.ones((4, 3))}
    with pytest.raises(UsageError, match=message):
        Samples(**{**good, **arguments})  # type: ignore[arg-type]


def test_one_column_of_sigma_serves_all_channels() -> None:
    samples = Samples(
        wi=np.array([UP]), wo=np.array([UP]), value=np.ones((1, 3)), sigma=np.array([0.5])
    )
    assert samples.sigma is not None
    assert samples.sigma.tolist() == [[0.5, 0.5, 0.5]]


def test_safe_directions_differ_only_where_nothing_is_used(five: Samples) -> None:
    lost = np.array([[np.nan, 0.0, 1.0], *five.wi[1:]])
    samples = Samples(wi=lost, wo=five.wo, value=five.value)
    wi, wo = samples.safe_directions
    assert wi[0].tolist() == wo[0].tolist() == [0.0, 0.0, 1.0]
    np.testing.assert_array_equal(wi[1:], five.wi[1:])
    np.testing.assert_array_equal(wo[1:], five.wo[1:])
