#!/usr/bin/env python3
"""The manifests by the schemas of Kubernetes, strictly (an unknown field is an error), what they must agree on, and
what kustomize makes of all components together.

kubernetes_test.py SOURCE_DIR     status 77: the schemas (PyPI: kubernetes-validate) or kubectl are not installed"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(sys.argv[1])
FOLDER = ROOT / "deploy/kubernetes"
NEWEST, OLDEST = "1.37", "1.29"
# Kinds that operators bring; the schemas know nothing of them.
OPERATORS = ("keda.sh/", "cert-manager.io/", "monitoring.coreos.com/")


def documents():
    for path in sorted(FOLDER.rglob("*.yaml")):
        for document in yaml.safe_load_all(path.read_text()):
            if not document["apiVersion"].startswith("kustomize"):
                yield path.name, document


def rendered():
    """The objects of a farm with all components, as `kubectl kustomize` makes them. Fails like it."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(FOLDER, f"{folder}/kubernetes")
        farm = Path(folder, "farm")
        farm.mkdir()
        shutil.copy(FOLDER / "farm.example.yaml", farm / "kustomization.yaml")
        made = subprocess.run(["kubectl", "kustomize", str(farm)], capture_output=True, text=True, timeout=60)
        if made.returncode != 0:
            raise SystemExit(made.stderr)
        return list(yaml.safe_load_all(made.stdout))


def schema_errors(validate, objects):
    for name, document in objects:
        if document["apiVersion"].startswith(OPERATORS):
            continue
        for version in (NEWEST, OLDEST):
            try:
                validate.validate(document, version, strict=True)
            except validate.ValidationError as error:
                yield f"{name}: {document['kind']} by {version}: {error.message} at {list(error.path)}"


def writable_mounts(pod):
    volumes = {volume["name"]: volume for volume in pod["volumes"]}
    return {mount["mountPath"]: volumes[mount["name"]] for mount in pod["containers"][0]["volumeMounts"]
            if "emptyDir" in volumes[mount["name"]]}


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
    worker = workers["spec"]["containers"][0]
    arguments = worker["args"]
    listened = int(arguments[arguments.index("--health") + 1].rpartition(":")[2])
    for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
        if worker.get(probe, {}).get("grpc", {}).get("port") != listened:
            yield f"the worker's {probe} does not ask at its --health"
    rules = yaml.safe_load((Path(sys.argv[1]) / "deploy/dashboards/alerts.yml").read_text())
    if found["PrometheusRule", "parallax"]["spec"] != rules:
        yield "monitoring/alerts.yaml is not deploy/dashboards/alerts.yml"
    service = found["Service", "parallax-coordinator"]
    monitor = found["ServiceMonitor", "parallax"]["spec"]
    if not monitor["selector"]["matchLabels"].items() <= service["metadata"]["labels"].items():
        yield "the ServiceMonitor selects no service"
    if not {end["port"] for end in monitor["endpoints"]} <= {port["name"] for port in service["spec"]["ports"]}:
        yield "the ServiceMonitor scrapes a port that the service does not have"
    for name, pod in (("the coordinator", found["StatefulSet", "parallax-coordinator"]["spec"]["template"]["spec"]),
                      ("the worker", workers["spec"])):
        mounts = writable_mounts(pod)
        if "/tmp" not in mounts:
            yield f"{name} can't write to /tmp"
    cache = arguments[arguments.index("--cache") + 1]
    for path in (arguments[arguments.index("--outbox") + 1], cache):
        if not any(path.startswith(mount + "/") for mount in mounts if mounts[mount] == mounts.get("/scratch")):
            yield f"the worker's {path} is not below the one volume for its files"
    # Pairs and own content.
    cached_gib = 2 * int(arguments[arguments.index("--cache-gb") + 1])
    if int(mounts["/scratch"]["emptyDir"]["sizeLimit"].removesuffix("Gi")) <= cached_gib:
        yield "the worker's caches fill its volume"
    keda = yaml.safe_load((FOLDER / "autoscale/kustomization.yaml").read_text())
    removed = [change for patch in keda["patches"] for change in yaml.safe_load(patch["patch"])]
    if {"op": "remove", "path": "/spec/replicas"} not in removed:
        yield "with KEDA, each apply sets the number of workers back"
    certificates = (FOLDER / "certificates/kustomization.yaml").read_text()
    given = set(re.findall(r"--from-literal=([a-z.]+)=", certificates)) | {"ca.crt", "tls.crt", "tls.key"}
    if given != {"ca.crt", "tls.crt", "tls.key", "http.token", "revoked"}:
        yield f"with cert-manager /tls has {sorted(given)}, which is not what `coordinator serve --tls` reads"
    grace_s = int(arguments[arguments.index("--grace") + 1])
    if grace_s >= workers["spec"]["terminationGracePeriodSeconds"]:
        yield f"workers are killed before their grace of {grace_s} s is over"


def project_version():
    text = (ROOT / "CMakeLists.txt").read_text()
    return re.search(r"^project\(parallax VERSION (\S+)", text, re.MULTILINE).group(1)


def farm_errors(objects):
    found = {(document["kind"], document["metadata"]["name"]): document for document in objects}
    secrets = {found[key]["spec"]["secretName"] for key in found if key[0] == "Certificate"}
    for kind, name in (("StatefulSet", "parallax-coordinator"), ("Deployment", "parallax-worker")):
        pod = found[kind, name]["spec"]["template"]["spec"]
        volume = next(volume for volume in pod["volumes"] if volume["name"] == "tls")
        sources = volume.get("projected", {}).get("sources", [volume])
        names = {source["secret"].get("name", source["secret"].get("secretName")) for source in sources}
        if not names & secrets:
            yield f"{name}: no Certificate makes one of its secrets {sorted(names)}"
        if pod["containers"][0]["image"] != f"registry.example/parallax:{project_version()}":
            yield f"{name}: the farm's registry is not named in its image"
    credentials = found["ServiceMonitor", "parallax"]["spec"]["endpoints"][0]["authorization"]["credentials"]
    if credentials["name"] != "coordinator-token":
        yield "the ServiceMonitor takes its token from a secret that has none beside cert-manager's"
    if "replicas" in found["Deployment", "parallax-worker"]["spec"]:
        yield "KEDA and the deployment both set the number of workers"
    if "kueue.x-k8s.io/queue-name" not in found["Deployment", "parallax-worker"]["metadata"].get("labels", {}):
        yield "the workers' deployment names no queue of Kueue"


def main():
    errors = list(disagreements())
    objects = list(documents())
    kubectl = shutil.which("kubectl")
    if kubectl:
        farm = rendered()
        errors += farm_errors(farm)
        objects += [("farm.example.yaml", document) for document in farm]
    try:
        import kubernetes_validate
    except ImportError:
        kubernetes_validate = None
    if kubernetes_validate:
        errors += schema_errors(kubernetes_validate, objects)
    for error in errors:
        print(error)
    if errors:
        return 1
    if not kubernetes_validate or not kubectl:
        print("SKIPPED: " + "; ".join(
            ([] if kubernetes_validate else ["the schemas (pip install kubernetes-validate brings them)"])
            + ([] if kubectl else ["what kustomize makes of the components (needs kubectl)"])))
        return 77
    print(f"{len(objects)} objects fit Kubernetes {OLDEST} to {NEWEST}")
    return 0


sys.exit(main())
