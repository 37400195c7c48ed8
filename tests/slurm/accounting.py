"""Slurm's accounting for a test cluster: a MariaDB and a slurmdbd of its own, below the cluster's folder.

They need Debian's packages slurmdbd and mariadb-server. `sacct` then tells what CPU time each job took.
"""

from __future__ import annotations

import getpass
import secrets
import subprocess
from pathlib import Path

PROGRAMS = ("slurmdbd", "mariadbd", "mariadb-install-db", "sacct")

# Lines of slurm.conf. AccountingStoragePass is munge's socket, which is no secret.
STORAGE = """\
AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=localhost
AccountingStoragePort={port}
AccountingStoragePass={folder}/munge.sock"""

SLURMDBD_CONF = """\
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock
DbdHost=localhost
DbdAddr=127.0.0.1
DbdPort={port}
SlurmUser={user}
PidFile={folder}/slurmdbd.pid
LogFile={folder}/slurmdbd.log
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort={database_port}
StorageUser=slurm
StoragePass={password}
StorageLoc=accounting
"""


def configure(folder: Path, port: int, database_port: int) -> None:
    """Write slurmdbd.conf, and make an empty database that only its user `slurm` enters."""
    password = secrets.token_hex(16)
    conf = folder / "slurmdbd.conf"
    conf.touch(mode=0o600)
    conf.write_text(
        SLURMDBD_CONF.format(
            folder=folder, port=port, user=getpass.getuser(), database_port=database_port, password=password
        )
    )
    first = folder / "first.sql"
    first.touch(mode=0o600)
    first.write_text(
        f"CREATE DATABASE accounting;\nCREATE USER slurm@'127.0.0.1' IDENTIFIED BY '{password}';\n"
        "GRANT ALL ON accounting.* TO slurm@'127.0.0.1';\n"
    )
    subprocess.run(
        [
            "mariadb-install-db",
            "--no-defaults",
            f"--user={getpass.getuser()}",
            f"--datadir={folder / 'database'}",
            "--skip-test-db",
        ],
        check=True,
        capture_output=True,
    )


def database_command(folder: Path, port: int) -> list[str]:
    """How the database is started, on the loopback interface only."""
    return [
        "mariadbd",
        "--no-defaults",
        f"--user={getpass.getuser()}",
        f"--datadir={folder / 'database'}",
        f"--socket={folder / 'database.sock'}",
        f"--pid-file={folder / 'database.pid'}",
        "--bind-address=127.0.0.1",
        f"--port={port}",
        f"--init-file={folder / 'first.sql'}",
        "--innodb-buffer-pool-size=64M",
    ]
