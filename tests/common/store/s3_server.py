"""An S3 server (moto) for one test: checks signatures, prints "PORT ACCESS_KEY SECRET_KEY" when it is ready and ends with
its standard input."""

import sys

import boto3
from moto.server import ThreadedMotoServer


def main():
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    _, port = server.get_host_and_port()
    endpoint = f"http://127.0.0.1:{port}"

    def client(service):
        return boto3.client(service, endpoint_url=endpoint, region_name="us-east-1", aws_access_key_id="setup",
                            aws_secret_access_key="setup")

    client("s3").create_bucket(Bucket="results")
    iam = client("iam")
    iam.create_user(UserName="worker")
    everything = '{"Version": "2012-10-17", "Statement": [{"Effect": "Allow", "Action": "s3:*", "Resource": "*"}]}'
    iam.put_user_policy(UserName="worker", PolicyName="all", PolicyDocument=everything)
    key = iam.create_access_key(UserName="worker")["AccessKey"]

    # From here on every request's signature is recomputed and must agree.
    import requests
    requests.post(endpoint + "/moto-api/reset-auth", data=b"0", timeout=10)

    print(port, key["AccessKeyId"], key["SecretAccessKey"], flush=True)
    sys.stdin.read()
    server.stop()


main()
