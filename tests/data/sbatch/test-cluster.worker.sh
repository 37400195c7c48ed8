#!/bin/bash
#SBATCH --job-name=gaitflow-quickstart-worker
#SBATCH --comment=gaitflow:76094578ebb6098f:4f1c2a-7
#SBATCH --output=/shared/project/runs/quickstart/logs/worker-%j.log
#SBATCH --open-mode=append
#SBATCH --time=00:10:00
#SBATCH --mem=500M
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --partition=work
#SBATCH --no-requeue
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export DASK_DISTRIBUTED__WORKER__HTTP__ROUTES='[]'
export DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False
export DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=1s
export DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL=10s
export DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__GIL__ENABLED=False
exec /shared/project/.venv/bin/python -m distributed.cli.dask_worker tls://10.0.0.5:40001 --name 4f1c2a-7 --nthreads 1 --no-nanny --memory-limit 0 --no-dashboard --dashboard-address 127.0.0.1:0 --death-timeout 60s --lifetime 285s --lifetime-stagger 15s --worker-class gaitflow.execute.drain.DrainingWorker --interface lo --protocol tls --tls-ca-file /shared/project/runs/quickstart/tls/certificate.pem --tls-cert /shared/project/runs/quickstart/tls/certificate.pem --tls-key /shared/project/runs/quickstart/tls/key.pem
