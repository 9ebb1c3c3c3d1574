"""Proposes trials of a search by Optuna's TPE: optuna_sampler.py ASK ANSWER (coordinator/search/README.md)."""

import json
import sys

import optuna
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution, IntDistribution

Field = dict[str, object]


def distribution(field: Field) -> BaseDistribution:
    if "choices" in field:
        return CategoricalDistribution(field["choices"])
    kind = IntDistribution if field["integer"] else FloatDistribution
    cast = int if field["integer"] else float
    return kind(cast(field["low"]), cast(field["high"]), log=field["log"])


def suggest(trial: optuna.Trial, field: Field) -> object:
    path = str(field["path"])
    if "choices" in field:
        return trial.suggest_categorical(path, field["choices"])
    if field["integer"]:
        return trial.suggest_int(path, int(field["low"]), int(field["high"]), log=field["log"])
    return trial.suggest_float(path, field["low"], field["high"], log=field["log"])


def propose(trial: optuna.Trial, space: list[Field]) -> dict[str, object]:
    values: dict[str, object] = {}
    for field in space:
        if all(values.get(when["path"]) in when["values"] for when in field.get("when", [])):
            values[field["path"]] = suggest(trial, field)
    return values


def main(ask_path: str, answer_path: str) -> None:
    with open(ask_path) as file:
        ask = json.load(file)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    seed = (ask["seed"] + len(ask["history"])) % 2**31
    sampler = optuna.samplers.TPESampler(multivariate=True, constant_liar=True, n_startup_trials=4, seed=seed)
    study = optuna.create_study(sampler=sampler)
    distributions = {field["path"]: distribution(field) for field in ask["space"]}
    for row in ask["history"]:  # Rows that have ended are told again, in their order.
        study.add_trial(optuna.trial.create_trial(
            params=row["values"], value=row.get("objective"),
            distributions={path: distributions[path] for path in row["values"]},
            state=optuna.trial.TrialState.COMPLETE if "objective" in row else optuna.trial.TrialState.FAIL))
    trials = [propose(study.ask(), ask["space"]) for _ in range(ask["count"])]
    with open(answer_path, "w") as file:
        json.dump({"trials": trials}, file)


main(sys.argv[1], sys.argv[2])
