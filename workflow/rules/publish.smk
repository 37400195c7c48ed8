rule publish:
    input:
        "runs/{scenario}/solutions.parquet",
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/learning/learning.json",
        "runs/{scenario}/learning/classifier.onnx",
    output:
        "runs/{scenario}/published.json",
    shell:
        "gaitflow publish {wildcards.scenario}"
