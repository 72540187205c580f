"""Every pair of effects, on asperities and on pixels: random scenes, their mirror images and loads
next to theirs are all solved, and their results are continuous."""

import numpy as np
import pair_scenes
import pytest
from metamorphic_scenes import Scene
from surfaces_csv import solve

NUMBERS = range(len(pair_scenes.PAIRS))
NAMES = [" ".join(pair) for pair in pair_scenes.PAIRS]
FEW, MANY, PARTS = 3, 100, 2


def check(asperity, folder, number, seeds):
    wrong = {seed: found for seed in seeds if (found := pair_scenes.faults(
        asperity, folder, pair_scenes.scene_of(number, seed)))}
    assert not wrong, wrong


@pytest.mark.parametrize("number", NUMBERS, ids=NAMES)
def test_few_scenes(number, asperity, tmp_path):
    check(asperity, tmp_path, number, range(FEW))


@pytest.mark.long
@pytest.mark.parametrize("part", range(PARTS))
@pytest.mark.parametrize("number", NUMBERS, ids=NAMES)
def test_many_scenes(number, part, asperity, tmp_path):
    check(asperity, tmp_path, number, range(part, MANY, PARTS))


@pytest.mark.parametrize("number, seed, was", [
    (1, 38, "the load jumped: a flattened contact next to another one opened"),
    (1, 2668, "the same, with an error estimate that is no number"),
    (2, 1825, "the load jumped with the number of boundary elements"),
    (2, 1964, "a load of inclined contacts was missed by 1e-4 where circles were merged"),
    (4, 32, "partial slip: a residual over a displacement of 0, where all sticks in full contact"),
    (4, 95, "partial slip: steps refused by the rounding of the energy"),
    (7, 4, "full contact at a held separation was refused by the sign of a rounding error"),
    (11, 136, "extrapolated steps repeated themselves"),
    (11, 1386, "near full contact equal forces had too little effect on the gaps"),
])
def test_found_seed(number, seed, was, asperity, tmp_path):
    found = pair_scenes.faults(asperity, tmp_path, pair_scenes.scene_of(number, seed))
    assert not found, (was, found)


FLATTENED = Scene(
    [(6.49828736948604, 9.022277669843758, 0.32501829675978455, 1.9288846790574135),
     (1.541797596331731, 10.549037828306432, 0.3355011449419979, 1.937330986465331),
     (5.829238451282872, 7.176983904332042, 0.3217804490208257, 1.4810455241234979)],
    [(1.3780744873281636, 10.382956565138816, 0.32287957110844295, 0.8263828014480253),
     (6.187444385838068, 7.170579131905241, 0.3187022238493986, 1.217815810010829),
     (6.422428878866213, 9.101865143035, 0.3005778400055648, 1.3756742885562956)],
    {"material": {"elastic_modulus": (2000.0, 2000.0), "poisson_ratio": (0.3, 0.3)},
     "loading": {"control": "load",
                 "value": (7.126869273257078, 3.5145324927411026, 8.552243127908493)},
     "effects": {"interaction": "auto", "plasticity": "on",
                 "plastic_yield_stress": 20.287699065026313}})
# The second contact touches between the last two states.
TOUCHING = Scene(
    [(2.882227445807336, 5.041789477798695, 0.3254792829378822, 0.7379898169323827),
     (2.033216330577097, 3.5522171955361492, 0.27637396834613004, 1.5707068838425762),
     (0.7346015030410429, 2.4318471367207826, 0.326005144158502, 1.2295993776651792)],
    [(2.9128708528345038, 4.756322832167271, 0.3186073503969698, 1.350522675195697),
     (1.0614122390392866, 3.5887781804163112, 0.3086012855801936, 0.7760522012155691),
     (1.7096157981486042, 3.2475503788138855, 0.3102935885457072, 1.9928511825792348),
     (2.679543814959354, 6.164824227865083, 0.31433709990237113, 1.694399511055305),
     (3.712479580793045, 5.105106825632261, 0.2728395747517152, 0.9730391372738882),
     (0.910278743442838, 2.497225837702071, 0.32985256336336716, 1.6117261592886258)],
    {"material": {"elastic_modulus": (2000.0, 2000.0), "poisson_ratio": (0.3, 0.3)},
     "loading": {"control": "load",
                 "value": (4.06833341508299, 2.1048525492937986, 4.882000098099588)},
     "effects": {"interaction": "coupled", "creep": "on", "relaxation_time": 1.0,
                 "relaxed_modulus_ratio": 0.27249370350633156, "hold_time": 3.0,
                 "hold_points": 3, "loading_time": 1.0}})


@pytest.mark.parametrize("scene, was", [
    (FLATTENED, "the energy of an open contact was that of a penetration of 0, not of its residual "
                "depth: the trust region shrank to nothing at a residual of 3e-3"),
    (TOUCHING, "the law of a contact changed in a step by the rounding error of its penetration, "
               "so that the load jumped by 1e-6")])
def test_found_scene(scene, was, asperity, tmp_path):
    assert not pair_scenes.faults(asperity, tmp_path, scene), was


def test_full_contact_in_creep(asperity, tmp_path):
    """Two equal changes of 1e-16 were taken for a series without end."""
    x, y = np.meshgrid(np.arange(10), np.arange(12), indexing="ij")
    height = 0.01 * (np.sin(2 * np.pi * x / 10) + np.cos(2 * np.pi * y / 12 + x / 3))
    for seed in range(12):
        rng = np.random.default_rng(seed)
        scene = pair_scenes.Map(
            height + 0.002 * rng.normal(size=height.shape), (0.1, 0.05),
            {"surfaces": {"map_edge": "periodic", "map_level": "none"},
             "material": {"contact_modulus": 340.0}, "loading": {"control": "load", "value": 0.65},
             "effects": {"interaction": "boundary", "adhesion": "on", "work_of_adhesion": 2.3,
                         "equilibrium_distance": 0.05, "adhesion_law": "exponential",
                         "creep": "on", "relaxation_time": 3.0, "relaxed_modulus_ratio": 0.4,
                         "hold_time": 3.0, "hold": "separation", "hold_points": 3,
                         "loading_time": 5.0}})
        answer = solve(asperity, scene.write(tmp_path), contacts=False)
        assert answer.status == 0, (seed, answer.stderr)


@pytest.mark.parametrize("model, pair", [(model, pair) for model, pairs in pair_scenes.APART.items()
                                         for pair in sorted(pairs)])
def test_pairs_without_a_theory(model, pair, asperity, tmp_path):
    """All other pairs are refused, so that no pair is left out above."""
    make = pair_scenes.asperities if model == "asperities" else pair_scenes.pixels
    answer = solve(asperity, make(np.random.default_rng(1), pair).write(tmp_path), contacts=False)
    assert answer.status == 2 and "do not go together" in answer.stderr
