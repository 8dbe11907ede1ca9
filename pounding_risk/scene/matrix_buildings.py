"""The [[building]] tables of buildings whose floors are joined by a matrix or by modes."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import permutations
from math import sqrt
from typing import Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.condensation import Condensed, Model, condensation_of, condensed_model
from pounding_risk.models.structures.matrices import assembled, symmetric
from pounding_risk.models.structures.storeys import BY_MATRIX, DAMPING_RULES, Storeys
from pounding_risk.scene import building_keys, matrices
from pounding_risk.scene.building_keys import WithFloors, wrong_initial, wrong_lengths
from pounding_risk.scene.keys import Key, Section, measured, whole_from
from pounding_risk.scene.toml import Fault


class FlooredBuilding(WithFloors):
    """A building whose floors are joined by more than storey springs; ``period`` scales all stiffnesses."""

    has_storeys = True
    floor_masses: tuple[float, ...] | float = building_keys.FLOOR_MASSES.required()
    storey_heights: tuple[float, ...] | float = building_keys.STOREY_HEIGHTS.required()
    period: float = building_keys.PERIOD.defaults_to(0.0)
    damping: float = building_keys.DAMPING.defaults_to(0.05)
    storey_stiffnesses: tuple[float, ...] | float = building_keys.STOREY_STIFFNESSES.defaults_to(())
    storey_strengths: tuple[float, ...] | float = building_keys.STOREY_STRENGTHS.defaults_to(())

    @classmethod
    @cache
    def keys(cls) -> dict[str, Key]:
        """The declarations of its keys by name, those that it must have first."""
        keys = super().keys()
        return {key: keys[key] for key in sorted(keys, key=lambda key: not cls.model_fields[key].is_required())}

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Storeys that yield have a stiffness and a strength."""
        for key, other in permutations(("storey_stiffnesses", "storey_strengths")):
            if key in keys and other not in keys:
                yield keys.fault(
                    key,
                    "a building by a matrix or modes has storeys that yield by storey_stiffnesses, the part of its "
                    f"matrix that yields, and storey_strengths; write {other} too, or remove {key}",
                )

    def floors(self, count: int) -> dict[str, Any]:
        """The fields of a structure that have one value for each of ``count`` floors, its name and its support."""
        fields = self.fields()
        facts = {key: fields[key] for key in ("name", "support", "displacement_history", "damping", "column_strength")}
        return facts | {building_keys.IN_STRUCTURES[key]: self.by_floor(key, count) for key in building_keys.LISTS}

    def completed(self, bare_building: Storeys) -> Storeys:
        """The building at the period of the table, damped as its matrix says, on its isolators, as it begins."""
        building = self.at_period(bare_building)
        if building.damping_matrix:
            building = replace(building, damping=building.first_damping())
        return super().completed(building)

    def at_period(self, building: Storeys) -> Storeys:
        """The building, stiffer or softer as a whole, so that its first mode has the period of the table."""
        factor = (building.period / self.period) ** 2 if self.period else 1.0
        if factor == 1.0:
            return building
        matrix = factor * np.array(building.stiffness_matrix)
        dashpots = sqrt(factor) * np.array(building.damping_matrix)  # the same ratios
        return replace(
            building,
            stiffnesses=tuple(factor * stiffness for stiffness in building.stiffnesses),
            stiffness_matrix=tuple(map(tuple, matrix.tolist())),
            damping_matrix=tuple(map(tuple, dashpots.tolist())),
            condensation=building.condensation and building.condensation.scaled(1.0 / sqrt(factor)),
        )


class MatrixBuilding(FlooredBuilding):
    """A building by the stiffness matrix of its floors, or of a model that is condensed to them."""

    repair = "a building with a stiffness_matrix takes no {key}; remove {key}, or stiffness_matrix"

    stiffness_matrix: Any = matrices.matrix_key(
        "K",
        matrices.OF_STIFFNESS,
        "Stiffness matrix of its floors along the row, from the ground up, in place of storey_stiffnesses: a file "
        "beside the scene (a row a line, or an array of NumPy), or rows; with the unit of its numbers. With "
        "floor_rows it may have rows of other places too, which are condensed.",
        "kN/m",
        "storey springs",
    ).required()
    floor_rows: tuple[int, ...] = matrices.rows_key(
        "Rows of stiffness_matrix that are floors, counted from 1, from the ground up; the others are condensed, "
        "which is exact where they carry neither mass nor damping.",
        "[3, 6]",
        "every row is a floor",
    ).defaults_to(())
    damping_matrix: Any = matrices.matrix_key(
        "C",
        matrices.OF_DASHPOTS,
        "Damping matrix of its floors, or of the rows of stiffness_matrix, in place of damping and damping_rule.",
        "kN s/m",
        "damping by damping_rule",
    ).defaults_to(())
    mass_matrix: Any = matrices.matrix_key(
        "M",
        matrices.OF_MASSES,
        "Mass matrix of the rows of stiffness_matrix, where masses are not lumped at floors; floor_masses beside "
        "it are those by which the ground's acceleration acts.",
        "t",
        "masses lumped at floors",
    ).defaults_to(())
    along_rows: tuple[int, ...] = matrices.rows_key(
        "Rows of mass_matrix that are displacements along the row, floors and others: the ground's acceleration "
        "acts on their masses.",
        "[1, 3, 4, 6]",
        "the floors; needed where other rows have mass and no floor_masses are given",
    ).defaults_to(())
    interior_modes: int = Key(
        "How many modes of the rows that are no floors, with the floors held, move beside the static motion: the "
        "slowest (Craig and Bampton 1968).",
        lambda value, number: whole_from(
            value,
            0,
            matrices.MOST_ROWS,
            f"is no number of modes; write a whole one from 0 to {matrices.MOST_ROWS}, such as 4",
        ),
        "4",
        "0: these rows follow the floors as under a steady load (Guyan)",
        schema={"type": "integer"},
    ).defaults_to(0)
    interior_masses: tuple[float, ...] = matrices.interior_key(
        "Masses by which the ground's acceleration acts on interior modes, of any sign, where the last rows of the "
        "matrices are such modes: of a model that has been condensed already.",
        '["12 t", "-4 t"]',
        "every row is a place of the model",
    ).defaults_to(())
    floor_masses: tuple[float, ...] | float = building_keys.FLOOR_MASSES.defaults_to(())
    damping_rule: str = building_keys.DAMPING_RULE.defaults_to(DAMPING_RULES[0])

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists without one value for each floor, no masses, and a damping that is given twice."""
        yield from super().checks(keys)
        matrix, names = keys.get("stiffness_matrix"), building_keys.LISTS
        if "floor_masses" not in keys and "mass_matrix" not in keys:
            yield keys.fault("floor_masses", cls.keys()["floor_masses"].lacks("floor_masses"), absent=True)
        if "along_rows" in keys and "mass_matrix" not in keys:
            yield keys.fault("along_rows", "names rows of a mass_matrix; write one, or remove along_rows")
        elif "along_rows" in keys and "floor_masses" in keys:
            yield keys.fault(
                "along_rows",
                "floor_masses beside a mass_matrix are the masses that the ground's acceleration acts on; remove "
                "along_rows, or floor_masses, which along_rows then give",
            )
        yield from _interior_faults(keys)
        if matrix and ("floor_rows" not in keys or keys.get("floor_rows")):
            count = len(keys.get("floor_rows") or matrix[len(keys.get("interior_masses") or ()) :])
            yield from wrong_lengths(keys, names, count, f"{count} floors of stiffness_matrix")
            yield from wrong_initial(keys, count, f"{count} floors of stiffness_matrix")
        for key in ("damping", "damping_rule"):
            if key in keys and "damping_matrix" in keys:
                yield keys.fault(key, f"damping_matrix says it all; remove {key}, or damping_matrix")

    def structure(self) -> Storeys:
        """Its floors, the matrices condensed to them and to interior modes."""
        try:
            model = self._model()
            is_complete = len(model.floors) + len(self.interior_masses) == len(model.stiffness)
            if self.interior_masses:
                driven = np.array([*self.by_floor("floor_masses", len(model.floors)), *self.interior_masses])
                reduced = Condensed(*model[:3], driven, np.eye(len(driven)))
            else:
                reduced = condensed_model(model, self.interior_modes)
        except PoundingError as error:
            raise PoundingError(f"{self.name}: {error}") from None
        fields = self.floors(len(model.floors)) | {
            "damping_rule": BY_MATRIX if self.damping_matrix else self.damping_rule
        }
        for field, matrix in zip(("stiffness_matrix", "mass_matrix", "damping_matrix"), reduced, strict=False):
            fields[field] = tuple(map(tuple, matrix.tolist()))
        if reduced.driven.size:
            masses = tuple(reduced.driven.tolist())
            fields |= {"masses": masses[: len(model.floors)], "interior_masses": masses[len(model.floors) :]}
        building = Storeys(**fields)
        if model.masses.size and not is_complete:
            condensation = condensation_of(model, reduced.motions, building.vibration())
            building = replace(building, condensation=condensation)
        return self.completed(building)

    def _model(self) -> Model:
        """The matrices of all rows, and which rows are floors or lie along the row."""
        matrix, empty_matrix = symmetric(self.stiffness_matrix, "stiffness_matrix"), np.zeros((0, 0))
        count = len(matrix) - len(self.interior_masses)
        if self.floor_rows and max(self.floor_rows) > len(matrix):
            raise PoundingError(f"floor_rows names row {max(self.floor_rows)} of {len(matrix)}")
        if count < 1:
            raise PoundingError(
                f"interior_masses are {len(self.interior_masses)} of {len(matrix)} rows, and none is a floor"
            )
        rows = self.floor_rows or tuple(range(1, 1 + count))
        return Model(
            matrix,
            self._masses(len(matrix), rows) if self.mass_matrix else empty_matrix,
            symmetric(self.damping_matrix, "damping_matrix") if self.damping_matrix else empty_matrix,
            rows,
            self.along_rows,
            self.by_floor("floor_masses", len(rows)) if self.floor_masses else (),
        )

    def _masses(self, size: int, rows: tuple[int, ...]) -> np.ndarray:
        """The mass matrix of the rows of the stiffness matrix."""
        matrix = symmetric(self.mass_matrix, "mass_matrix")
        if len(matrix) != size:
            raise PoundingError(
                f"mass_matrix has {counted(len(matrix), 'row')}, stiffness_matrix {size}; give the same rows "
                "in both, in the same order"
            )
        bad_rows = [row for row in self.along_rows if row > len(matrix)] or sorted(set(rows) - set(self.along_rows))
        if self.along_rows and bad_rows:
            words = (
                f"names row {bad_rows[0]} of {len(matrix)}"
                if bad_rows[0] > len(matrix)
                else f"lacks the floor {bad_rows[0]}"
            )
            raise PoundingError(f"along_rows {words}; write all rows that are displacements along the row")
        return matrix


def _interior_faults(keys: Section) -> Iterator[Fault]:
    """The faults of keys of interior modes without the keys that they need, or with those that they exclude."""
    for key in ("interior_modes", "interior_masses"):
        if keys.get(key) and "mass_matrix" not in keys:
            sentence = f"modes of rows that are no floors need their masses; write mass_matrix, or remove {key}"
            yield keys.fault(key, sentence)
    if keys.get("interior_modes") and "interior_masses" in keys:
        sentence = "interior_masses says that the matrices have these modes; remove one of the two"
        yield keys.fault("interior_modes", sentence)
    elif keys.get("interior_modes"):
        if "floor_rows" not in keys:
            yield keys.fault("interior_modes", "every row is a floor; write floor_rows, or remove interior_modes")
        if "floor_masses" in keys:
            sentence = (
                "do not say what the ground's acceleration acts on in interior_modes; write along_rows in their place"
            )
            yield keys.fault("floor_masses", sentence)
    if "interior_masses" in keys:
        if "floor_masses" not in keys:
            yield keys.fault("interior_masses", "stand beside floor_masses, the same of the floors; write these too")
        for key in ("floor_rows", "along_rows"):
            if key in keys:
                yield keys.fault(key, f"beside interior_masses the floors are the first rows; remove {key}")


class ModalBuilding(FlooredBuilding):
    """A building by modes of motion along the row, as programs of structural analysis write them."""

    repair = "a building with modes takes no {key}; remove {key}, or modes"

    modes: Any = matrices.MODES.required()
    residual_period: float = measured(
        building_keys.BUILDING_PERIOD,
        "Period of all motion that its modes leave out: floors move in it when a neighbour strikes them.",
        '"0.05 s"',
        "a third of the shortest period of modes",
    ).defaults_to(0.0)

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each floor."""
        yield from super().checks(keys)
        table = keys.get("modes")
        count = len(table.shapes[0]) if table else 0
        if table:
            yield from wrong_lengths(keys, building_keys.LISTS, count, f"{count} floors of modes")
            yield from wrong_initial(keys, count, f"{count} floors of modes")
            if table.dampings and "damping" in keys:
                yield keys.fault("damping", "modes has a damping of its own for each; remove one of the two")

    def structure(self) -> Storeys:
        """Its floors, with the matrices of its modes."""
        fields = self.floors(len(self.modes.shapes[0]))
        masses = np.array(fields["masses"])
        try:
            stiffness, dashpots = assembled(self.modes, masses, self.damping, self.residual_period)
        except PoundingError as error:
            raise PoundingError(f"{self.name}: {error}") from None
        if dashpots is not None:
            fields["damping_rule"] = BY_MATRIX
            fields["damping_matrix"] = tuple(map(tuple, dashpots.tolist()))
        return self.completed(Storeys(**fields, stiffness_matrix=tuple(map(tuple, stiffness.tolist()))))
