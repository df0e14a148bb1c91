"""Container and Kubernetes files: sound by their schemas, of a piece with each other and with the programs.
Needs PyYAML; the schemas come with kubernetes-validate (PyPI), that of MPIJob is the operator's CRD, whose file
PARRAY_MPIJOB_CRD names. What is missing is skipped."""

import copy
import os
import pathlib
import re
import subprocess
import unittest

from packs import BIN, SOURCE

try:
    import yaml
except ImportError:
    yaml = None
needs_yaml = unittest.skipIf(yaml is None, "PyYAML is not installed (python3-yaml)")

KUBERNETES = SOURCE / "deploy/kubernetes"
CONTAINER = SOURCE / "deploy/container"


def documents(name):
    return list(yaml.safe_load_all((KUBERNETES / name).read_text()))


def of_kind(kind):
    for path in sorted(KUBERNETES.glob("*.yaml")):
        for document in documents(path.name):
            if document["kind"] == kind and path.name != "http-probes.yaml":
                return document
    raise AssertionError(kind)


def patched(base, patch):
    """A strategic merge, as far as the patch here needs it: lists of named things by their names."""
    if isinstance(base, dict) and isinstance(patch, dict):
        merged = dict(base)
        for key, value in patch.items():
            merged[key] = patched(base.get(key), value)
        return {key: value for key, value in merged.items() if value is not None}
    if isinstance(patch, list) and patch and isinstance(patch[0], dict):
        merged = {item["name"]: item for item in copy.deepcopy(base or [])}
        for item in patch:
            merged[item["name"]] = patched(merged.get(item["name"]), item)
        return list(merged.values())
    return patch


def strict(schema):
    """The schema that takes no property beyond those that it names."""
    if isinstance(schema, list):
        return [strict(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    closed = {key: strict(value) for key, value in schema.items()}
    if isinstance(schema.get("properties"), dict) and "additionalProperties" not in schema \
            and not schema.get("x-kubernetes-preserve-unknown-fields"):
        closed["additionalProperties"] = False
    return closed


def pods(document):
    """The pod templates of a resource."""
    spec = document["spec"]
    if "mpiReplicaSpecs" in spec:
        return [replica["template"]["spec"] for replica in spec["mpiReplicaSpecs"].values()]
    return [spec["template"]["spec"]] if "template" in spec else []


@needs_yaml
class Schemas(unittest.TestCase):
    def validate(self, document):
        try:
            import kubernetes_validate
        except ImportError:
            self.skipTest("kubernetes-validate is not installed (pip)")
        kubernetes_validate.validate(document, kubernetes_validate.latest_version(), strict=True)

    def test_kubernetes_takes_every_resource(self):
        for name in ("coordinator.yaml", "worker.yaml"):
            for document in documents(name):
                with self.subTest(name=name, kind=document["kind"]):
                    self.validate(document)

    def test_kubernetes_takes_the_coordinator_with_http(self):
        self.validate(patched(of_kind("StatefulSet"), documents("http-probes.yaml")[0]))

    def test_the_mpi_operator_takes_the_job(self):
        crd = os.environ.get("PARRAY_MPIJOB_CRD")
        if not crd:
            self.skipTest("PARRAY_MPIJOB_CRD does not name the CRD of MPIJob")
        import jsonschema
        job = of_kind("MPIJob")
        versions = {version["name"]: version for version in yaml.safe_load(pathlib.Path(crd).read_text())["spec"]["versions"]}
        schema = strict(versions[job["apiVersion"].split("/")[1]]["schema"]["openAPIV3Schema"])
        schema["properties"]["metadata"].pop("additionalProperties", None)
        jsonschema.validate(job, schema)


@needs_yaml
class OfAPiece(unittest.TestCase):
    def images(self):
        targets = re.findall(r"^FROM \S+ AS (\S+)$", (CONTAINER / "Containerfile").read_text(), re.MULTILINE)
        return {"parray-" + target for target in targets}

    def test_images_are_built_here(self):
        services = yaml.safe_load((CONTAINER / "compose.yaml").read_text())["services"]
        used = {service["image"] for service in services.values()}
        for kind in ("StatefulSet", "Deployment", "MPIJob"):
            for pod in pods(of_kind(kind)):
                used |= {container["image"] for container in pod["containers"] + pod.get("initContainers", [])}
        self.assertLessEqual(used, self.images())
        for service in services.values():
            if "build" in service:
                self.assertEqual("parray-" + service["build"]["target"], service["image"])

    def known(self, program, words):
        said = subprocess.run([BIN / program, "--help"], capture_output=True, text=True).stdout
        options = [word for word in words if word.startswith("--")]
        self.assertTrue(options)
        return [option for option in options if not re.search(re.escape(option) + r"\b", said)]

    def test_the_coordinator_knows_its_options(self):
        words = of_kind("StatefulSet")["spec"]["template"]["spec"]["containers"][0]["args"]
        words += yaml.safe_load((CONTAINER / "compose.yaml").read_text())["services"]["coordinator"]["command"]
        words += re.findall(r"--\w+", (CONTAINER / "Containerfile").read_text().split('ENTRYPOINT ["parray-coordinator",')[1].split("]")[0])
        self.assertEqual(self.known("parray-coordinator", words), [])

    def test_the_coordinator_knows_the_options_of_http(self):
        words = documents("http-probes.yaml")[0]["spec"]["template"]["spec"]["containers"][0]["args"]
        if self.known("parray-coordinator", words) == ["--http"]:
            self.skipTest("this parray-coordinator has no --http")
        self.assertEqual(self.known("parray-coordinator", words), [])

    def test_no_annotation_asks_prometheus_to_scrape_without_the_token_that_keys_require(self):
        template = patched(of_kind("StatefulSet"), documents("http-probes.yaml")[0])["spec"]["template"]
        self.assertIn("--keys", template["spec"]["containers"][0]["args"])
        self.assertFalse([name for name in template["metadata"].get("annotations", {}) if "prometheus.io" in name])

    def test_names_of_kubernetes_resources_agree(self):
        service, coordinator = of_kind("Service"), of_kind("StatefulSet")
        worker, scaler = of_kind("Deployment"), of_kind("HorizontalPodAutoscaler")
        for resource in (coordinator, worker):
            self.assertEqual(resource["spec"]["selector"]["matchLabels"], resource["spec"]["template"]["metadata"]["labels"])
        self.assertEqual(service["spec"]["selector"], coordinator["spec"]["selector"]["matchLabels"])
        self.assertEqual(coordinator["spec"]["serviceName"], service["metadata"]["name"])
        self.assertEqual(scaler["spec"]["scaleTargetRef"]["name"], worker["metadata"]["name"])
        address = {variable["name"]: variable["value"] for variable in pods(worker)[0]["containers"][0]["env"]}
        self.assertEqual(address["PARRAY_COORDINATOR"], f"tcp://{service['metadata']['name']}:{service['spec']['ports'][0]['port']}")

    def test_nobody_is_root(self):
        for kind in ("StatefulSet", "Deployment", "MPIJob"):
            for pod in pods(of_kind(kind)):
                self.assertTrue(pod["securityContext"]["runAsNonRoot"])
                self.assertEqual(pod["securityContext"]["runAsUser"], 7400)
        stages = (CONTAINER / "Containerfile").read_text().split("\nFROM ")
        for stage in stages:
            if re.match(r"\S+ AS (worker|coordinator|client|mpi)\b", stage):
                self.assertEqual(re.findall(r"^USER (\S+)$", stage, re.MULTILINE)[-1], "7400:7400")


if __name__ == "__main__":
    unittest.main()
