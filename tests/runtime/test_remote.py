"""Published folders at addresses: a real HTTP server, and a real server of S3's protocol."""

from __future__ import annotations

import json
import os
import re
import shutil
import threading
from collections.abc import Iterator
from functools import partial
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import boto3
import pytest
from click.testing import CliRunner, Result
from moto.server import ThreadedMotoServer
from s3fs import S3FileSystem

from gaitflow.cli import main
from gaitflow.core.errors import ArtifactError
from gaitflow.dataset import load_solutions
from gaitflow.files import sha256_file
from gaitflow.publishing.upload import upload
from gaitflow.publishing.versioned_folder import PublishError, VersionExists
from gaitflow.runtime import GaitMap
from gaitflow.runtime.remote import fetch

NAME = "half-cheetah-exact-vibration"
TASK = ("--speed", "0.9", "--cycle", "0.6")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "gaitflow"


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *arguments: object) -> None:
        pass


@pytest.fixture
def web(checkout: Path, tmp_path: Path) -> Iterator[tuple[str, Path]]:
    """The address of a web server, and the folder that it serves: one map with its dataset."""
    root = tmp_path / "web"
    for kind in ("models", "datasets"):
        shutil.copytree(checkout / kind / NAME, root / kind / NAME)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(root))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}", root
        server.shutdown()


@pytest.fixture(scope="module")
def s3() -> Iterator[str]:
    """The address of a bucket on a server of its own."""
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    endpoint = "http://{}:{}".format(*server.get_host_and_port())
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {
            "AWS_ENDPOINT_URL_S3": endpoint,
            "AWS_ACCESS_KEY_ID": "nobody",
            "AWS_SECRET_ACCESS_KEY": "nothing",
            "AWS_DEFAULT_REGION": "us-east-1",
        }.items():
            patch.setenv(name, value)
        boto3.client("s3").create_bucket(Bucket="maps")
        yield "s3://maps"
    server.stop()


class Flipping(BaseHTTPRequestHandler):
    """Hands requests on to the server of S3's protocol, and flips a bit of the file `spoiled` when it is read.

    It leaves out the checksums that the server keeps, unless `checksums`: by them the client itself finds the fault.
    """

    protocol_version = "HTTP/1.1"  # objects are sent once the server said that it will go on

    def __init__(self, spoiled: str, checksums: bool, endpoint: str, *arguments: Any) -> None:
        self.spoiled, self.checksums, self.host = spoiled, checksums, endpoint.removeprefix("http://")
        super().__init__(*arguments)

    def hand_on(self) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        connection = HTTPConnection(self.host)
        headers = {name: value for name, value in self.headers.items() if name != "Expect"}
        connection.request(self.command, self.path, body, headers)
        answer = connection.getresponse()
        content = bytearray(answer.read())
        if self.command == "GET" and self.path.endswith(self.spoiled):
            content[len(content) // 2] ^= 1
        self.send_response(answer.status)
        for name, value in answer.getheaders():
            left_out = not self.checksums and name.lower().startswith("x-amz-checksum")
            if not left_out and name.lower() not in ("connection", "date", "server"):
                self.send_header(name, value)
        self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(content)

    do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = hand_on

    def log_message(self, format: str, *arguments: object) -> None:
        pass


def call(*arguments: object) -> Result:
    return CliRunner().invoke(main, [*map(str, arguments)])


@pytest.mark.parametrize("version", ["", "/1.1.0"])
def test_a_map_is_loaded_from_the_web_and_kept(
    web: tuple[str, Path], checkout: Path, cache: Path, version: str
) -> None:
    address = f"{web[0]}/models/{NAME}{version}"
    here = GaitMap.load(checkout / "models" / NAME)
    there = GaitMap.load(address)
    assert there.manifest.files == here.manifest.files
    assert there.plan(0.9, 0.6).cost == pytest.approx(here.plan(0.9, 0.6).cost)
    (kept,) = cache.iterdir()
    assert kept.name == sha256_file(kept / "manifest.json")
    (web[1] / "models" / NAME / "1.1.0" / "atlas.safetensors").unlink()
    assert fetch(address) == kept, "of what is kept only the manifest is asked for again"


def test_what_is_kept_may_be_deleted(web: tuple[str, Path], cache: Path) -> None:
    address = f"{web[0]}/models/{NAME}"
    before = fetch(address)
    shutil.rmtree(cache)
    assert GaitMap.load(address).plan(0.9, 0.6).feasible and before.is_dir()


@pytest.mark.parametrize("file", ["atlas.safetensors", "classifier.onnx", "README.md"])
@pytest.mark.parametrize("damage", ["flipped", "longer", "shorter", "missing"])
def test_a_file_that_is_not_what_the_manifest_lists_is_not_loaded(
    web: tuple[str, Path], cache: Path, file: str, damage: str
) -> None:
    path = web[1] / "models" / NAME / "1.1.0" / file
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    changed = {"flipped": content, "longer": path.read_bytes() + b"x", "shorter": path.read_bytes()[:-1]}
    path.unlink() if damage == "missing" else path.write_bytes(changed[damage])
    with pytest.raises(ArtifactError, match=rf"{file}: (its content is not what the manifest|cannot be read)"):
        GaitMap.load(f"{web[0]}/models/{NAME}")
    assert not cache.exists() or not list(cache.iterdir())


@pytest.mark.parametrize("name", ["../outside", "/etc/passwd", ".hidden", "a/b"])
def test_a_manifest_leads_nowhere_else(web: tuple[str, Path], tmp_path: Path, name: str) -> None:
    path = web[1] / "models" / NAME / "1.1.0" / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["files"][name] = {"sha256": "0" * 64, "bytes": 1}
    path.write_text(json.dumps(manifest))
    with pytest.raises(ArtifactError, match="lists files that no published map or dataset has"):
        fetch(f"{web[0]}/models/{NAME}")


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("{web}/models/nowhere", "nowhere: cannot be read"),
        ("{web}/models", "holds no manifest.json and no versions"),
        ("http://127.0.0.1:1/models", "127.0.0.1:1/models: cannot be read"),
        ("nosuch://host/models", "cannot be opened"),
    ],
)
def test_an_address_without_a_map_is_one_line(web: tuple[str, Path], address: str, says: str) -> None:
    for command in (("plan", *TASK), ("labels",), ("verify",)):
        done = call(command[0], address.format(web=web[0]), *command[1:])
        assert done.exit_code == 2 and says in done.stderr and len(done.stderr.splitlines()) == 1


def test_commands_take_addresses(web: tuple[str, Path], checkout: Path) -> None:
    for kind in ("models", "datasets"):
        found = call("verify", f"{web[0]}/{kind}/{NAME}")
        assert found.exit_code == 0 and found.stdout.endswith(": sound\n"), found.output
    dataset = f"{web[0]}/datasets/{NAME}"
    assert call("labels", dataset).stdout == call("labels", checkout / "datasets" / NAME).stdout
    assert len(load_solutions(dataset)) == len(load_solutions(checkout / "datasets" / NAME / "1.1.0"))
    assert call("show", dataset, *TASK).exit_code == 0


def test_a_version_is_published_to_s3_once_and_loaded_from_there(s3: str, checkout: Path) -> None:
    for kind in ("models", "datasets"):
        done = call("upload", checkout / kind / NAME, f"{s3}/{kind}")
        assert done.exit_code == 0 and done.stdout == f"{s3}/{kind}/{NAME}/1.1.0\n", done.output
    plan = call("plan", f"{s3}/models/{NAME}", *TASK, "--json")
    assert plan.exit_code == 0 and json.loads(plan.stdout)["feasible"], plan.output
    assert call("verify", f"{s3}/datasets/{NAME}/1.1.0").exit_code == 0
    with pytest.raises(VersionExists, match="is published already and never changes"):
        upload(checkout / "models" / NAME / "1.1.0", f"{s3}/models")
    refused = call("upload", checkout / "models" / NAME, "s3://no-such-bucket/models")
    assert refused.exit_code == 1 and "cannot be written" in refused.stderr and len(refused.stderr.splitlines()) == 1


def test_a_damaged_version_is_not_published(s3: str, checkout: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(checkout / "models" / NAME / "1.1.0", tmp_path / "1.1.0")
    (copy / "README.md").write_text("edited")
    with pytest.raises(PublishError, match=r"README.md: its content is not what the manifest lists"):
        upload(copy, f"{s3}/damaged")


@pytest.mark.parametrize(
    ("file", "checksums", "says"),
    [
        ("atlas.safetensors", False, "atlas.safetensors reads otherwise than it was sent; upload again"),
        ("manifest.json", False, "manifest.json reads otherwise than it was sent; upload again"),
        ("manifest.json", True, r"cannot be written \(.*checksum"),
    ],
)
def test_what_does_not_read_as_it_was_sent_is_not_published(
    s3: str, checkout: Path, monkeypatch: pytest.MonkeyPatch, file: str, checksums: bool, says: str
) -> None:
    address = f"{s3}/spoiled-{file}-{checksums}"
    handler = partial(Flipping, file, checksums, os.environ["AWS_ENDPOINT_URL_S3"])
    with monkeypatch.context() as patch, ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        patch.setenv("AWS_ENDPOINT_URL_S3", f"http://127.0.0.1:{server.server_port}")
        S3FileSystem.clear_instance_cache()
        done = call("upload", checkout / "models" / NAME, address)
        server.shutdown()
    S3FileSystem.clear_instance_cache()
    assert done.exit_code == 1 and re.search(says, done.stderr), done.output
    with pytest.raises(ArtifactError, match=r"cannot be read|holds no manifest"):
        fetch(f"{address}/{NAME}")
    assert fetch(upload(checkout / "models" / NAME / "1.1.0", address)).is_dir(), "it may be uploaded again"


def test_a_changed_object_in_s3_is_not_loaded(s3: str, checkout: Path) -> None:
    target = upload(checkout / "models" / NAME / "1.1.0", f"{s3}/changed")
    boto3.client("s3").put_object(Bucket="maps", Key=f"changed/{NAME}/1.1.0/classifier.onnx", Body=b"other")
    with pytest.raises(ArtifactError, match=r"classifier.onnx: its content is not what the manifest lists"):
        GaitMap.load(target)


def test_a_folder_of_this_machine_is_an_address_too(checkout: Path, tmp_path: Path) -> None:
    target = upload(checkout / "models" / NAME / "1.1.0", f"file://{tmp_path}/share/models")
    assert (tmp_path / "share/models" / NAME / "1.1.0" / "manifest.json").exists()
    assert GaitMap.load(target).gaits == GaitMap.load(checkout / "models" / NAME).gaits
