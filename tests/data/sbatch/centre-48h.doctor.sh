#!/bin/bash
#SBATCH --job-name=gaitflow-doctor
#SBATCH --comment=gaitflow:a06db5e27931630e:doctor
#SBATCH --output=/shared/project/runs/.doctor-1/log
#SBATCH --open-mode=append
#SBATCH --time=00:05:00
#SBATCH --mem=2G
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --partition=cpu
#SBATCH --account=my-project
#SBATCH --no-requeue
#SBATCH --qos=normal
#SBATCH --constraint=rome
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export TMPDIR="$TMPDIR"
module purge
module load gcc/12
exec /shared/project/.venv/bin/python -m gaitflow.execute.doctor_node /shared/project/runs/.doctor-1 --scratch "$TMPDIR"
