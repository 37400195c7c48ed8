#!/bin/bash
#PBS -N gaitflow-quickstart-driver
#PBS -v GAITFLOW_JOB=gaitflow:76094578ebb6098f:driver
#PBS -S /bin/bash
#PBS -j oe
#PBS -o /shared/project/runs/quickstart/logs/
#PBS -l select=1:ncpus=1:mem=8gb
#PBS -l walltime=48:00:00
#PBS -q workq
#PBS -A my-project
#PBS -r y
#PBS -W group_list=robots
exec >> "/shared/project/runs/quickstart/logs/driver-${PBS_JOBID%%.*}.log" 2>&1
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export TMPDIR="$TMPDIR"
export GAITFLOW_DRIVER_JOB="${PBS_JOBID%%.*}"
export PATH="$PATH:/opt/pbs/bin"
module purge
module load gcc/12
cd /shared/project || exit 1
stop=
child=
trap 'stop=requeue; kill -TERM "$child" 2>/dev/null' USR1
trap 'stop=end; kill -TERM "$child" 2>/dev/null' TERM
(
  trap 'kill "$nap"' TERM
  sleep 172740 &
  nap=$!
  wait "$nap" && kill -USR1 $$
) > /dev/null 2>&1 < /dev/null &
notice=$!
trap 'kill "$notice" 2>/dev/null' EXIT
run() {
  code=1
  if [ -z "$stop" ]; then
    "$@" &
    child=$!
    wait "$child"; code=$?
    while kill -0 "$child" 2>/dev/null; do wait "$child"; code=$?; done
  fi
  if [ -z "$stop" ] && [ "$code" -gt 128 ] && [ "${GAITFLOW_RESTARTS:-0}" -lt 20 ]; then stop=requeue; fi
  if [ "$stop" = requeue ]; then qsub -v "GAITFLOW_JOB=$GAITFLOW_JOB,GAITFLOW_RESTARTS=$((${GAITFLOW_RESTARTS:-0} + 1))" /shared/project/runs/quickstart/cluster/driver.sh; fi
  if [ -n "$stop" ] || [ "$code" -ne 0 ]; then exit "$code"; fi
}
run /shared/project/.venv/bin/python -m gaitflow.cli --root /shared/project solve quickstart --profile /shared/project/runs/quickstart/cluster/profile.yaml
run /shared/project/.venv/bin/python -m gaitflow.cli --root /shared/project run quickstart --workers 1
