#!/bin/bash
#PBS -N gaitflow-quickstart-worker
#PBS -v GAITFLOW_JOB=gaitflow:76094578ebb6098f:4f1c2a-7
#PBS -S /bin/bash
#PBS -j oe
#PBS -o /shared/project/runs/quickstart/logs/
#PBS -l select=1:ncpus=1:mem=2gb
#PBS -l walltime=48:00:00
#PBS -q workq
#PBS -A my-project
#PBS -r n
#PBS -W group_list=robots
exec >> "/shared/project/runs/quickstart/logs/worker-${PBS_JOBID%%.*}.log" 2>&1
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export TMPDIR="$TMPDIR"
export DASK_DISTRIBUTED__WORKER__HTTP__ROUTES='[]'
export DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False
export DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=1s
export DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL=10s
export DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__GIL__ENABLED=False
export PATH="$PATH:/opt/pbs/bin"
module purge
module load gcc/12
exec /shared/project/.venv/bin/python -m distributed.cli.dask_worker tls://10.0.0.5:40001 --name 4f1c2a-7 --nthreads 1 --no-nanny --memory-limit 0 --no-dashboard --dashboard-address 127.0.0.1:0 --death-timeout 60s --lifetime 163476s --lifetime-stagger 8604s --worker-class gaitflow.execute.drain.DrainingWorker --interface ib0 --protocol tls --tls-ca-file /shared/project/runs/quickstart/tls/certificate.pem --tls-cert /shared/project/runs/quickstart/tls/certificate.pem --tls-key /shared/project/runs/quickstart/tls/key.pem --local-directory "$TMPDIR"
