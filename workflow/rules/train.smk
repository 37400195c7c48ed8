rule train:
    input:
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/gait_costs.parquet",
        "runs/{scenario}/learning/atlas.safetensors",
        "runs/{scenario}/learning/atlas.json",
        part("learning"),
    output:
        "runs/{scenario}/learning/learning.json",
        "runs/{scenario}/learning/classifier.onnx",
    threads: 2
    params:
        scenario=named,
    shell:
        "gaitflow train {params.scenario:q}"
