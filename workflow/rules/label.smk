rule label:
    input:
        "runs/{scenario}/solutions.parquet",
        part("ties"),
    output:
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/gait_costs.parquet",
    shell:
        "gaitflow label {wildcards.scenario}"
