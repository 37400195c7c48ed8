rule report:
    input:
        "runs/{scenario}/solutions.parquet",
        "runs/{scenario}/labels.parquet",
        "runs/{scenario}/learning/learning.json",
        "runs/{scenario}/published.json",
    output:
        "runs/{scenario}/report/index.html",
    params:
        scenario=named,
    shell:
        "gaitflow report {params.scenario:q}"
