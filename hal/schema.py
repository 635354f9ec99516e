"""What every section of a file is made of."""

from pydantic import BaseModel, ConfigDict


class Row(BaseModel):
    """Base of everything read from a file: unknown keys, NaN and infinities are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
