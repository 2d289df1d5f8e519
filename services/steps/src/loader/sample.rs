//! Sample of a loader's sensor message.

use estimation::loader::Sample;
use messages::LoaderSensors as SensorsMessage;

use crate::rows::sample_of_message;

sheet::loader_signals!(sample_of_message);
