#!/bin/bash
#PBS -N gaitflow-doctor
#PBS -v GAITFLOW_JOB=gaitflow:a06db5e27931630e:doctor
#PBS -S /bin/bash
#PBS -j oe
#PBS -o /dev/null
#PBS -l select=1:ncpus=1:mem=2gb
#PBS -l walltime=00:05:00
#PBS -q workq
#PBS -A my-project
#PBS -r n
#PBS -W group_list=robots
exec >> "/shared/project/runs/.doctor-1/log" 2>&1
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
export MKL_NUM_THREADS=1
export TMPDIR="$TMPDIR"
export PATH="$PATH:/opt/pbs/bin"
module purge
module load gcc/12
exec /shared/project/.venv/bin/python -m gaitflow.execute.doctor_node /shared/project/runs/.doctor-1 --scratch "$TMPDIR"
