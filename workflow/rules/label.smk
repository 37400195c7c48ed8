rule label:
    input:
        "runs/{scenario}/solutions.parquet",
        part("ties"),
    output:
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/gait_costs.parquet",
    params:
        scenario=named,
    shell:
        "gaitflow label {params.scenario:q}"
