"""Regenerate the ``*_pb2`` modules: ``python logs_schema/generate.py`` (needs grpcio-tools)."""

import subprocess
import sys
from pathlib import Path


def main() -> int:
    """Run protoc on every .proto file of the package; returns its exit code."""
    folder = Path(__file__).parent
    names = sorted(f"labrig_schema/{path.name}" for path in folder.glob("labrig_schema/*.proto"))
    command = [sys.executable, "-m", "grpc_tools.protoc", "-I.", "--python_out=.", "--pyi_out=.", *names]
    return subprocess.run(command, cwd=folder, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
