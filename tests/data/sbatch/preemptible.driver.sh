#!/bin/bash
#SBATCH --job-name=gaitflow-quickstart-driver
#SBATCH --comment=gaitflow:76094578ebb6098f:driver
#SBATCH --output=/shared/project/runs/quickstart/logs/driver-%j.log
#SBATCH --open-mode=append
#SBATCH --time=7-00:00:00
#SBATCH --mem=4G
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --partition=standard
#SBATCH --requeue
#SBATCH --signal=B:USR1@60
#SBATCH --nice=100
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export TMPDIR="/tmp"
export GAITFLOW_DRIVER_JOB="$SLURM_JOB_ID"
cd /shared/project || exit 1
stop=
child=
trap 'stop=requeue; kill -TERM "$child" 2>/dev/null' USR1
trap 'stop=end; kill -TERM "$child" 2>/dev/null' TERM
run() {
  code=1
  if [ -z "$stop" ]; then
    "$@" &
    child=$!
    wait "$child"; code=$?
    while kill -0 "$child" 2>/dev/null; do wait "$child"; code=$?; done
  fi
  if [ -z "$stop" ] && [ "$code" -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 20 ]; then stop=requeue; fi
  if [ "$stop" = requeue ]; then scontrol requeue "$SLURM_JOB_ID"; fi
  if [ -n "$stop" ] || [ "$code" -ne 0 ]; then exit "$code"; fi
}
run /shared/project/.venv/bin/python -m gaitflow.cli --root /shared/project solve quickstart --profile /shared/project/runs/quickstart/cluster/profile.yaml
run /shared/project/.venv/bin/python -m gaitflow.cli --root /shared/project run quickstart --workers 1
