#!/bin/bash
#SBATCH --job-name=gaitflow-doctor
#SBATCH --comment=gaitflow:a06db5e27931630e:doctor
#SBATCH --output=/shared/project/runs/.doctor-1/log
#SBATCH --open-mode=append
#SBATCH --time=00:05:00
#SBATCH --mem=500M
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --partition=work
#SBATCH --no-requeue
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
exec /shared/project/.venv/bin/python -m gaitflow.execute.doctor_node /shared/project/runs/.doctor-1
