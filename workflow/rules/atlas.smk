rule atlas:
    input:
        "runs/{scenario}/solutions.parquet",
        "runs/{scenario}/labels.parquet",
    output:
        "runs/{scenario}/learning/atlas.safetensors",
        "runs/{scenario}/learning/predictors.json",
    shell:
        "gaitflow atlas {wildcards.scenario}"
