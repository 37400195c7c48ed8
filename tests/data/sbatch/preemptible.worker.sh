#!/bin/bash
#SBATCH --job-name=gaitflow-quickstart-worker
#SBATCH --comment=gaitflow:76094578ebb6098f:4f1c2a-7
#SBATCH --output=/shared/project/runs/quickstart/logs/worker-%j.log
#SBATCH --open-mode=append
#SBATCH --time=06:00:00
#SBATCH --mem=2G
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --partition=scavenge
#SBATCH --no-requeue
#SBATCH --nice=100
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export TMPDIR="/tmp"
export DASK_DISTRIBUTED__WORKER__HTTP__ROUTES='[]'
export DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False
export DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=1s
export DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL=10s
export DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__GIL__ENABLED=False
exec /shared/project/.venv/bin/python -m distributed.cli.dask_worker tls://10.0.0.5:40001 --name 4f1c2a-7 --nthreads 1 --no-nanny --memory-limit 0 --no-dashboard --dashboard-address 127.0.0.1:0 --death-timeout 60s --lifetime 19836s --lifetime-stagger 1044s --worker-class gaitflow.execute.drain.DrainingWorker --protocol tls --tls-ca-file /shared/project/runs/quickstart/tls/certificate.pem --tls-cert /shared/project/runs/quickstart/tls/certificate.pem --tls-key /shared/project/runs/quickstart/tls/key.pem --local-directory "/tmp"
