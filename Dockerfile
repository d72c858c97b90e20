# Lockprobe and all that its first command needs. docs/container.md says how to use it.
#
#   docker build -t lockprobe .
#   docker run --rm -it --user "$(id -u):$(id -g)" -v "$PWD:/studies" lockprobe

# Debian keeps no old versions of its packages, so none is pinned.
# hadolint global ignore=DL3008

FROM python:3.13-slim-trixie

# libgomp1 is for local models; EGL and Mesa draw the physical box without a screen and without a graphics card.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends libegl-mesa0 libegl1 libgl1-mesa-dri libgomp1 libopengl0 \
    && rm -rf /var/lib/apt/lists/*

RUN pip install --no-cache-dir uv==0.13.9 \
    && useradd --create-home --uid 1000 lockprobe


ENV UV_COMPILE_BYTECODE=1 \
    UV_LINK_MODE=copy \
    UV_NO_CACHE=1 \
    UV_PROJECT_ENVIRONMENT=/opt/lockprobe \
    UV_PYTHON_DOWNLOADS=never

# Packages change less often than the source: they have a layer of their own.
WORKDIR /source
COPY pyproject.toml uv.lock ./
COPY robot/pyproject.toml robot/README.md robot/
# A container without a robot needs none of the libraries of robots; they exist for few platforms.
ARG NO_ROBOT="--no-extra fr3 --no-extra realsense"
RUN uv sync --locked --no-install-workspace --all-packages --all-extras $NO_ROBOT --group embedded

# Releases are counted from git tags, which are not here: --build-arg VERSION=... states the version.
ARG VERSION=""
COPY LICENSE README.md ./
COPY src src
COPY robot/src robot/src
RUN SETUPTOOLS_SCM_PRETEND_VERSION="$VERSION" uv sync --locked --no-editable --all-packages --all-extras $NO_ROBOT --group embedded \
    && install --directory --mode 1777 /studies

# Any user will do (docker run --user): nothing is written outside /studies and /tmp.
ENV HOME=/tmp \
    PATH=/opt/lockprobe/bin:$PATH

USER 1000
WORKDIR /studies
EXPOSE 8765
STOPSIGNAL SIGINT
ENTRYPOINT ["lockprobe"]
CMD ["run", "flips"]
