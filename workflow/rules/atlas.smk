rule atlas:
    input:
        "runs/{scenario}/solutions.parquet",
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/gait_costs.parquet",
    output:
        "runs/{scenario}/learning/atlas.safetensors",
        "runs/{scenario}/learning/atlas.json",
    threads: workflow.cores or 2
    params:
        scenario=named,
    shell:
        "gaitflow atlas {params.scenario:q} --workers {threads}"
