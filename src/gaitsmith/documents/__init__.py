"""One reader for documents that a stranger wrote: cards, scenarios, motions, gaits."""

from gaitsmith.documents.about import About as About
from gaitsmith.documents.about import Frozen as Frozen
from gaitsmith.documents.about import Name as Name
from gaitsmith.documents.about import Worded as Worded
from gaitsmith.documents.about import about as about
from gaitsmith.documents.about import check_name as check_name
from gaitsmith.documents.about import written_as as written_as
from gaitsmith.documents.reading import checked as checked
from gaitsmith.documents.reading import parse_json as parse_json
from gaitsmith.documents.reading import parse_toml as parse_toml
from gaitsmith.documents.reading import read_toml as read_toml
from gaitsmith.documents.reading import toml as toml
from gaitsmith.documents.refusal import nearest as nearest
from gaitsmith.documents.refusal import plain as plain
from gaitsmith.documents.refusal import span as span
