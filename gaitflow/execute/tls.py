"""Only those who can read a run's key may talk to its scheduler on a shared network.

Dask's scheduler runs whatever code it is sent. So both sides of every connection show the one certificate of the run,
which is made anew for every session and lies where only its owner can read it.
"""

from __future__ import annotations

import datetime
import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from distributed.security import Security

VALID_DAYS = 365
CLOCK_SLACK = datetime.timedelta(days=1)  # nodes' clocks need not agree


def tls_files(run_folder: Path) -> tuple[Path, Path]:
    """Where a run's certificate and its key are; whether they exist or not."""
    folder = run_folder.resolve() / "tls"
    return folder / "certificate.pem", folder / "key.pem"


@contextmanager
def session_security(run_folder: Path) -> Iterator[Security]:
    """New credentials for scheduler, workers and clients, removed at the end of the block.

    They lie in `<run folder>/tls` (0700, files 0600), which all nodes have to see. Raises OSError when that folder
    belongs to somebody else, or cannot be written.
    """
    certificate, key = tls_files(run_folder)
    folder = certificate.parent
    run_folder.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    about = folder.lstat()
    if not stat.S_ISDIR(about.st_mode) or about.st_uid != os.getuid():
        raise PermissionError(f"{folder}: must be a folder of your own, it will hold a key; remove it and run again")
    folder.chmod(0o700)  # whatever it was before
    certificate_text, key_text = _new_certificate()
    try:
        _write_secret(key, key_text)
        _write_secret(certificate, certificate_text)
        yield security(run_folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def security(run_folder: Path) -> Security:
    """The credentials of a run that is on, for whoever may read them."""
    certificate, key = map(str, tls_files(run_folder))
    roles = {f"tls_{role}_cert": certificate for role in ("client", "scheduler", "worker")}
    keys = {f"tls_{role}_key": key for role in ("client", "scheduler", "worker")}
    return Security(require_encryption=True, tls_ca_file=certificate, **roles, **keys)


def _new_certificate() -> tuple[bytes, bytes]:
    """A self-signed certificate, its own authority, and its key; both PEM."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "gaitflow run")])
    now = datetime.datetime.now(datetime.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCK_SLACK)
        .not_valid_after(now + datetime.timedelta(days=VALID_DAYS))
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(key, hashes.SHA256())
    )
    encoding, plain = serialization.Encoding.PEM, serialization.NoEncryption()
    return certificate.public_bytes(encoding), key.private_bytes(encoding, serialization.PrivateFormat.PKCS8, plain)


def _write_secret(path: Path, data: bytes) -> None:
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with open(descriptor, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
