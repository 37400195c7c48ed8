rule publish:
    input:
        "runs/{scenario}/solutions.parquet",
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/gait_costs.parquet",
        "runs/{scenario}/learning/learning.json",
        "runs/{scenario}/learning/classifier.onnx",
        "runs/{scenario}/learning/atlas.safetensors",
        "runs/{scenario}/learning/atlas.json",
    output:
        "runs/{scenario}/published.json",
    params:
        scenario=named,
    shell:
        "gaitflow publish {params.scenario:q}"
