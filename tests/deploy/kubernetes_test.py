#!/usr/bin/env python3
"""The manifests by the schemas of Kubernetes, strictly (an unknown field is an error), and what they must agree on.

kubernetes_test.py SOURCE_DIR     status 77: the schemas (PyPI: kubernetes-validate) are not installed"""

import sys
from pathlib import Path

import yaml

FOLDER = Path(sys.argv[1]) / "deploy/kubernetes"
NEWEST, OLDEST = "1.37", "1.29"


def documents():
    for path in sorted(FOLDER.glob("*.yaml")):
        for document in yaml.safe_load_all(path.read_text()):
            yield path.name, document


def schema_errors(validate):
    for name, document in documents():
        if document["apiVersion"].startswith("keda.sh/"):
            continue
        for version in (NEWEST, OLDEST):
            try:
                validate.validate(document, version, strict=True)
            except validate.ValidationError as error:
                yield f"{name}: {document['kind']} by {version}: {error.message} at {list(error.path)}"


def disagreements():
    found = {(document["kind"], document["metadata"]["name"]): document for _, document in documents()}
    workers = found["Deployment", "parallax-worker"]["spec"]["template"]
    budget = found["PodDisruptionBudget", "parallax-worker"]["spec"]
    if not budget["selector"]["matchLabels"].items() <= workers["metadata"]["labels"].items():
        yield "the disruption budget selects no worker"
    scaled = found["ScaledObject", "parallax-worker"]["spec"]
    if ("Deployment", scaled["scaleTargetRef"]["name"]) not in found:
        yield f"the ScaledObject's target {scaled['scaleTargetRef']['name']} is no Deployment here"
    trigger = scaled["triggers"][0]
    source = (Path(sys.argv[1]) / "coordinator/http/metrics_text.cc").read_text()
    if "parallax_demand_slots" not in trigger["metadata"]["query"] or '"demand_slots"' not in source:
        yield "the ScaledObject asks for a metric that the coordinator does not have"
    if any(not isinstance(value, str) for value in trigger["metadata"].values()):
        yield "a trigger's metadata are strings"
    coordinator = found["StatefulSet", "parallax-coordinator"]["spec"]["template"]["spec"]["containers"][0]
    for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
        if probe not in coordinator:
            yield f"the coordinator has no {probe}"
    arguments = workers["spec"]["containers"][0]["args"]
    grace_s = int(arguments[arguments.index("--grace") + 1])
    if grace_s >= workers["spec"]["terminationGracePeriodSeconds"]:
        yield f"workers are killed before their grace of {grace_s} s is over"


def main():
    errors = list(disagreements())
    try:
        import kubernetes_validate
    except ImportError:
        kubernetes_validate = None
    if kubernetes_validate:
        errors += schema_errors(kubernetes_validate)
    for error in errors:
        print(error)
    if errors:
        return 1
    if not kubernetes_validate:
        print("SKIPPED: the schemas; pip install kubernetes-validate brings them")
        return 77
    print(f"{len(list(documents()))} objects fit Kubernetes {OLDEST} to {NEWEST}")
    return 0


sys.exit(main())
