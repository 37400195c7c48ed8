# Durable and resumable by itself: the store of units in runs/{scenario}/units is no output, so Snakemake
# never deletes it, and a rerun solves only the units that a changed scenario added.
rule solve:
    input:
        part("problem"),
    output:
        "runs/{scenario}/solutions.parquet",
    threads: workflow.cores or 2
    params:
        scenario=named,
    shell:
        "gaitflow solve {params.scenario:q} --workers {threads}"
