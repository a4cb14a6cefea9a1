# The command `onset` without a toolchain:
#   docker build --tag onset .
#   docker run --rm --volume "$PWD:/work" onset state study.toml --stretch 1.2,1
FROM rust:1-slim-bookworm AS build
WORKDIR /source
COPY . .
RUN cargo build --release --locked --package onset-cli
RUN apt-get update && apt-get install --yes --no-install-recommends python3 \
    && python3 python/licenses.py /THIRD-PARTY-LICENSES.txt onset-cli

FROM debian:bookworm-slim
COPY --from=build /source/target/release/onset /usr/local/bin/
COPY --from=build /THIRD-PARTY-LICENSES.txt /usr/share/doc/onset/
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/onset/
WORKDIR /work
ENTRYPOINT ["onset"]
