"""Conditions of a study: weather and time of day; on the cool morning hardships for the decision, and other persons."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from aos_gcs.errors import ConfigurationError
from aos_sim.errors.model import ErrorModel
from aos_sim.world.conditions import Conditions
from aos_sim.world.distractors import Distractor, DistractorKind
from aos_sim.world.person import Person, Posture
from aos_sim.world.scene import Scene, SceneParameters

_NEVER_WARM = (DistractorKind.CLOTH, DistractorKind.WATER)


@dataclass(frozen=True, slots=True)
class StudyConditions:
    """What differs from the cool morning."""

    weather: Conditions = Conditions.COOL
    skin_covered: bool = False
    """Whether every person wears a hood, gloves and a cloth over the face."""
    persons_cooler_k: float = 0.0
    """Cooling of clothes and skin, while all else keeps its temperature."""
    distractors_warmer_k: float = 0.0
    """Warming of animals, stones and stumps."""
    blur: float = 1.0
    """Factor of the standard deviation of both cameras' point spread functions."""
    persons: int = 1
    """Persons in a forest that is not empty."""
    in_pairs: bool = False
    """Whether every second person keeps company to the one before, 0.8 to 2 m away."""
    walking_mps: float = 0.0
    """Speed at which persons walk to and fro; 0: they stay, in the posture that is drawn."""

    def drawn(self, parameters: SceneParameters) -> SceneParameters:
        """Return the parameters of a scene with their weather, and their persons where it has any."""
        persons = self.persons * parameters.persons
        parameters = replace(parameters, conditions=self.weather, persons=persons, in_pairs=self.in_pairs)
        if not self.walking_mps:
            return parameters
        return replace(parameters, posture=Posture.WALKING, walking_mps=self.walking_mps)

    def scene(self, scene: Scene) -> Scene:
        """Return a scene with its bodies altered; places and forest stay."""
        return replace(
            scene,
            persons=tuple(map(self._person, scene.persons)),
            distractors=tuple(map(self._distractor, scene.distractors)),
        )

    def errors(self, errors: ErrorModel) -> ErrorModel:
        """Return an error model with its optics altered."""
        optics = errors.optics
        return replace(
            errors,
            optics=replace(
                optics,
                thermal_blur_px=self.blur * optics.thermal_blur_px,
                colour_blur_px=self.blur * optics.colour_blur_px,
            ),
        )

    def _person(self, person: Person) -> Person:
        dressed = replace(person, hooded=True, gloved=True, masked=True) if self.skin_covered else person
        return replace(
            dressed,
            skin_temperature_celsius=person.skin_temperature_celsius - self.persons_cooler_k,
            clothing_temperature_celsius=person.clothing_temperature_celsius - self.persons_cooler_k,
        )

    def _distractor(self, distractor: Distractor) -> Distractor:
        warmer_k = 0.0 if distractor.kind in _NEVER_WARM else self.distractors_warmer_k
        return replace(
            distractor,
            temperature_celsius=distractor.temperature_celsius + warmer_k,
            bare_temperature_celsius=distractor.bare_temperature_celsius + warmer_k,
        )


STUDY_CONDITIONS: Mapping[str, StudyConditions] = {
    **{str(weather): StudyConditions(weather) for weather in Conditions},
    "no-skin": StudyConditions(skin_covered=True),
    "persons-2k-cooler": StudyConditions(persons_cooler_k=2.0),
    "persons-4k-cooler": StudyConditions(persons_cooler_k=4.0),
    "distractors-3k-warmer": StudyConditions(distractors_warmer_k=3.0),
    "blurred": StudyConditions(blur=2.0),
    "two-persons": StudyConditions(persons=2),
    "pair": StudyConditions(persons=2, in_pairs=True),
    "walking": StudyConditions(walking_mps=1.0),
}


def study_conditions(name: str) -> StudyConditions:
    """Return the conditions of a name.

    Raises:
        ConfigurationError: there are no such conditions.
    """
    if name not in STUDY_CONDITIONS:
        raise ConfigurationError(f"conditions must be one of {', '.join(STUDY_CONDITIONS)}, but are {name!r}.")
    return STUDY_CONDITIONS[name]
